"""ReLU between two butterflies: from the results of a product to the operand of the next one."""

from typing import Any

from amaranth import Cat, Module, Mux, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.learned.plan import UNITS, mirror_bits
from tfra.hdl.parallel.payloads import product
from tfra.model.fixed.learned.design import LearnedDesign


class Activation(wiring.Component):
    """Folded units from folded sums; the model is :func:`tfra.model.fixed.learned.activation.activation`.

    ::

        result -> Butterfly -> max(0, .) -> Butterfly -> units

    One block for all layers, since no more than one quad leaves the lanes in a cycle.  Sums in front of a unit are no
    longer than that at a mirror, by the bounds of :mod:`tfra.model.fixed.learned.bounds`.  Nothing waits; no
    multiplier, sixteen adders.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self._kinds = [number for number, name in enumerate(design.kinds) if name in UNITS]
        self._unfold, self._fold = (Butterfly(mirror_bits(design)) for _ in range(2))
        result = product(design)
        units = data.StructLayout(result.members | {"words": self._fold.o.p.shape()})
        super().__init__({
            "result": In(always_ready_stream(result)),  # of all products; those of ``UNITS`` are looked at
            "units": Out(always_ready_stream(units)),  # the same quads as units, with their operator
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a result to that of its units."""
        return self._unfold.latency + self._fold.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.unfold, m.submodules.fold = unfold, fold = self._unfold, self._fold
        result, units = self.result, self.units
        selected: Value = result.valid & Cat(result.p.kind[number] for number in self._kinds).any()
        bits = len(fold.i.p[0])
        m.d.comb += [
            unfold.i.valid.eq(selected),
            *(into.eq(word) for into, word in zip(unfold.i.p, result.p.words, strict=True)),
            unfold.o.ready.eq(1),
            fold.i.valid.eq(unfold.o.valid),
            *(fold.i.p[k].eq(Mux(word[-1], 0, word[:bits])) for k, word in enumerate(unfold.o.p)),
            fold.o.ready.eq(1),
            units.valid.eq(fold.o.valid),
            units.p.words.eq(fold.o.p),
            units.p.kind.eq(delayed(m, result.p.kind, self.latency, "kind")),
        ]
        return m
