"""Operands of ``z + s * x``: the choice among the stores of each, and the products of forces."""

from typing import Any, NamedTuple

from amaranth import Array, C, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring

from tfra.hdl.lib.pipeline import register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import SkidBuffer
from tfra.hdl.parallel.beats import select_beat, vector_beats
from tfra.hdl.parallel.payloads import vector_beat
from tfra.hdl.parallel.scale_add import Stage
from tfra.hdl.parallel.tfra.combine.store import FRAMES, Job, Store
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction

_RING = 16
"""Places of the ring buffer of products, a power of two."""


def multiplicand(m: Module, n: Store, residual: Store, e1: Store, tag: dict[Stage, Any]) -> tuple[Value, Value]:
    """x of the beat in stage ``X_CHOSEN``, and its headroom: d_dep for e0 and e1, e1 for d, n for a force.

    ``residual``: d1 (vector 0) and d2 (vector 1).
    """
    address = tag[Stage.X_ADDRESS]
    for store in (n, residual, e1):
        store.read_at(m, address)
    m.d.comb += residual.read.vector.eq(~address.swap)
    sources, job = {Job.E0: residual, Job.E1: residual, Job.D: e1, Job.FORCE: n}, tag[Stage.X_READ].job
    words = Array(sources[job].beat.as_value() for job in Job)[job]
    headroom = Array(sources[job].headroom.as_value() for job in Job)[job]
    return register(m, words, "x"), register(m, headroom, "x_headroom")


def addend(m: Module, design: Design, residual: Store, e0: Store, product: Value, tag: dict[Stage, Any]) -> Value:
    """z of the beat in stage ``Z``: d0 for e0, d_ind for e1, e0 for d, the ``product`` in ``ENTRY`` for a force.

    ``residual``: d0, d1 and d2 (vectors 0, 1, 2).
    """
    address, job = tag[Stage.Z_ADDRESS], tag[Stage.Z_READ].job
    for store in (residual, e0):
        store.read_at(m, address)
    m.d.comb += residual.read.vector.eq(Mux(address.job == Job.E0, 0, Mux(address.swap, 2, 1)))
    chosen = register(m, Mux(job == Job.D, e0.beat.as_value(), residual.beat.as_value()), "chosen")
    is_force = register(m, job == Job.FORCE, "is_force")
    return register(m, Mux(is_force, _late(m, design, product), chosen), "z")


def _late(m: Module, design: Design, product: Value) -> Value:
    """The product of the beat in stage ``Z_CHOSEN``, from a ring buffer with one place a cycle."""
    cycles = Stage.Z_CELL - Stage.ENTRY
    assert cycles < _RING
    ring = Ram(m, "products", vector_beat(design), _RING)
    cycle = Signal(range(_RING))
    m.d.sync += cycle.eq(cycle + 1)
    ring.write(1, cycle, product)
    return register(m, ring.read(cycle - cycles).as_value(), "product")


class ProductBeats(NamedTuple):
    """Beats of the products of forces, A-dagger d, in the cycles in which they enter."""

    valid: Value
    words: Value
    place: Value
    """That of its frame."""
    number: Value
    """Its number in its product."""
    scalar: Value
    """One of mu_x, mu_y and -1: that of the beat that entered a cycle ago."""
    frame_done: Value
    """Pulse, a cycle after the entry of a frame's last beat."""


def product_beats(m: Module, design: Design, products: Any, forced: Any) -> ProductBeats:
    """Products enter when they arrive: 3 Q quads a frame, A1-dagger d, A2-dagger d, A3-dagger d.

    ``forced``: fact of the frame, there before them, taken when those of the frame before have entered.
    """
    m.submodules.forced = facts = SkidBuffer(forced.payload.shape())
    wiring.connect(m, wiring.flipped(forced), facts.i)
    valid, number, ends = vector_beats(m, design, products.valid)
    plane, _ = wrapping_counter(m, ends, 3, "plane")
    _, last = wrapping_counter(m, valid, 3 * design.quads * design.cycles_per_quad, "beat_in_frame")
    place, _ = wrapping_counter(m, valid & last, FRAMES, "place")
    minus_one = C(-1 << scalar_fraction(design), signed(design.formats.bits("scalar")))
    # TIMING: matvec's result router -> queue of facts, scalar of a beat
    entered_last = register(m, valid & last, "entered_last", control=True)
    entered_plane = register(m, plane, "entered_plane")
    m.d.comb += facts.o.ready.eq(entered_last)
    scalar = Array([facts.o.p.mu_x, facts.o.p.mu_y, minus_one])[entered_plane]
    return ProductBeats(valid, select_beat(design, products.payload, number), place, number, scalar, entered_last)
