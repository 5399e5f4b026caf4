"""The angle of a frame's tangential force, and the moduli of its gain, from one CORDIC."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.streams import Buffer, always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import Cordic, cordic_latency, cordic_modulus, cordic_vector
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, iterations
from tfra.model.fixed.design import Design


class Angle(wiring.Component):
    """phi = atan2(sin, cos) of every frame, in a free slot of the CORDIC.

    ::

        vector ────────────┬─▶ Cordic ─┬─▶ turned
        direction ─▶ buffer┘           └─▶ negative ─▶ +- atan 2^-i ─▶ angle ─▶ phi

    A mark passes through the CORDIC with a direction, so that the sign of each of its rotations adds to the angle, one
    a cycle.  The rounding is added before the first.  ``vector`` has priority; a direction enters in the next cycle
    without a vector, when the previous phi has left.

    Members:
        vector: stream in, x and y.
        turned: stream out, the modulus, ``latency`` cycles later.
        direction: fact of the frame; ``cos`` and ``sin`` are looked at.
        phi: stream out, one transfer a direction.

    Resources: a Cordic, an adder.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "vector": In(always_ready_stream(cordic_vector(design))),
                "turned": Out(always_ready_stream(cordic_modulus(design))),
                "direction": In(stream.Signature(payloads.direction(design))),
                "phi": Out(stream.Signature(unsigned(iterations(design)))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``vector`` to that of ``turned``."""
        return cordic_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.cordic = cordic = Cordic(self._design)
        m.submodules.waiting = waiting = Buffer(payloads.direction(self._design))
        wiring.connect(m, wiring.flipped(self.direction), waiting.i)
        marks = Signal(len(cordic.negative))  # bit i: the direction is before rotation i
        busy = Signal()  # from the entry of a direction until its phi has left
        enter = waiting.o.valid & ~busy & ~self.vector.valid
        m.d.sync += marks.eq(Cat(enter, marks))
        m.d.comb += [
            cordic.vector.valid.eq(self.vector.valid),
            waiting.o.ready.eq(marks[0]),
            self.turned.valid.eq(cordic.turned.valid),
            self.turned.payload.eq(cordic.turned.payload),
        ]
        guard = self._design.widths.division - self._design.formats.bits("direction")
        for into, word in (("x", "cos"), ("y", "sin")):
            direction = waiting.o.p[word] << guard
            m.d.comb += cordic.vector.p[into].eq(Mux(self.vector.valid, self.vector.p[into], direction))
        angle = self._add(m, enter, marks, cordic.negative, waiting.o.p.cos[-1])
        m.d.comb += self.phi.payload.eq(angle[ANGLE_GUARD:])
        with m.If(self.phi.valid & self.phi.ready):
            m.d.sync += busy.eq(0)
        with m.If(enter):
            m.d.sync += busy.eq(1)
        complete = delayed(m, marks[-1], 2, "complete", control=True)
        with m.If(complete):
            m.d.sync += self.phi.valid.eq(1)
        with m.Elif(self.phi.ready):
            m.d.sync += self.phi.valid.eq(0)
        return m

    def _add(self, m: Module, enter: Value, marks: Value, negative: Value, left: Value) -> Signal:
        """The angle: half a turn for a vector of the left half plane, and the turn of each rotation, a cycle late.

        ``rotation`` is the one whose turn is looked up: the next one of the direction.
        """
        table, half = angle_table(self._design), 1 << (ANGLE_GUARD - 1)
        angle = Signal(iterations(self._design) + ANGLE_GUARD, name="angle_so_far", reset_less=True)
        rotation = Signal(counter_shape(len(table)), reset_less=True)
        table += [0] * ((1 << len(rotation)) - len(table))  # all of them, so that nothing is compared
        step = register(m, Array(Const(value, len(angle)) for value in table)[rotation], "step")
        up = register(m, (marks & negative).any(), "up")
        going = register(m, marks.any(), "going", control=True)
        m.d.sync += rotation.eq(Mux(enter, 0, rotation + 1))
        with m.If(marks[0]):
            m.d.sync += angle.eq(Mux(left, (1 << (len(angle) - 1)) + half, half))
        with m.Elif(going):
            m.d.sync += angle.eq(add_or_subtract(angle, step, up))
        return angle
