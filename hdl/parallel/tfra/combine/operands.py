"""Operands of ``z + s * x``: the stores of each, and the choice among them."""

from typing import Any

from amaranth import Array, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel.payloads import vector_beat
from tfra.hdl.parallel.scale_add import Stage, beat_headroom
from tfra.hdl.parallel.tfra.combine.stages import Job, tag_layout
from tfra.hdl.parallel.tfra.combine.store import Store, store_write
from tfra.model.fixed.design import Design

_RING = 16
"""Places of the ring buffer of products, a power of two."""


class Multiplicand(wiring.Component):
    """x: d_dep for e0 and e1, e1 for d, n for a force."""

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "n": In(store_write(design)),  # beats to be written
            "residual": In(store_write(design, 2)),  # beats of d1 (vector 0) and d2 (vector 1) to be written
            "e1": In(store_write(design)),  # beats to be written
            "address": In(tag_layout(design)),  # tag of the beat in stage ``X_ADDRESS``
            "job": In(Job),  # that of the beat in stage ``X_READ``
            "words": Out(vector_beat(design)),  # x of the beat in stage ``X_CHOSEN``
            "headroom": Out(beat_headroom(design.widths.vector, design.architecture.vector_words)),  # that of ``words``
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design, address = self._design, self.address
        m.submodules.n_store = n = Store(design, headroom=True)
        m.submodules.residual_store = residual = Store(design, 2, headroom=True)
        m.submodules.e1_store = e1 = Store(design, headroom=True)
        for store, port in ((n, self.n), (residual, self.residual), (e1, self.e1)):
            wiring.connect(m, wiring.flipped(port), store.write)
            m.d.comb += store.read.place.eq(address.place)
            m.d.comb += store.read.number.eq(address.number)
        m.d.comb += residual.read.vector.eq(~address.swap)
        sources = {Job.E0: residual, Job.E1: residual, Job.D: e1, Job.FORCE: n}
        words = Signal(self.words.shape(), reset_less=True)
        headroom = Signal(self.headroom.shape(), reset_less=True)
        m.d.sync += [
            words.eq(Array(sources[job].beat.as_value() for job in Job)[self.job]),
            headroom.eq(Array(sources[job].headroom.as_value() for job in Job)[self.job]),
        ]
        m.d.comb += self.words.eq(words)
        m.d.comb += self.headroom.eq(headroom)
        return m


class Addend(wiring.Component):
    """z: d0 for e0, d_ind for e1, e0 for d, a product for a force."""

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "residual": In(store_write(design, 3)),  # beats of d0, d1, d2 (vectors 0, 1, 2) to be written
            "e0": In(store_write(design)),  # beats to be written
            "product": In(vector_beat(design)),  # words of the beat in stage ``ENTRY``, if it is of a product
            "address": In(tag_layout(design)),  # tag of the beat in stage ``Z_ADDRESS``
            "job": In(Job),  # that of the beat in stage ``Z_READ``
            "words": Out(vector_beat(design)),  # z of the beat in stage ``Z``
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design, address = self._design, self.address
        m.submodules.residual_store = residual = Store(design, 3)
        m.submodules.e0_store = e0 = Store(design)
        for store, port in ((residual, self.residual), (e0, self.e0)):
            wiring.connect(m, wiring.flipped(port), store.write)
            m.d.comb += store.read.place.eq(address.place)
            m.d.comb += store.read.number.eq(address.number)
        m.d.comb += residual.read.vector.eq(Mux(address.job == Job.E0, 0, Mux(address.swap, 2, 1)))
        chosen = register(m, Mux(self.job == Job.D, e0.beat.as_value(), residual.beat.as_value()), "chosen")
        is_force = register(m, self.job == Job.FORCE, "is_force")
        words = Signal(self.words.shape(), reset_less=True)
        m.d.sync += words.eq(Mux(is_force, self._product(m), chosen))
        m.d.comb += self.words.eq(words)
        return m

    def _product(self, m: Module) -> Value:
        """The product of the beat in stage ``Z_CHOSEN``, from a ring buffer with one place a cycle."""
        cycles = Stage.Z_CELL - Stage.ENTRY
        assert cycles < _RING
        ring = Ram(m, "products", vector_beat(self._design), _RING)
        cycle = Signal(range(_RING))
        m.d.sync += cycle.eq(cycle + 1)
        ring.write(1, cycle, self.product)
        return register(m, ring.read(cycle - cycles).as_value(), "product")
