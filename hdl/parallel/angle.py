"""The angle of a frame's tangential force, and the moduli of its gain, from one CORDIC."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import Buffer, always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import Cordic, cordic_modulus, cordic_vector, summed_angle
from tfra.model.fixed.cordic import ANGLE_GUARD, iterations
from tfra.model.fixed.design import Design


class Angle(wiring.Component):
    """phi = atan2(sin, cos) of every frame, in a free slot of the CORDIC.

    ::

        vector ────────────┬─▶ Cordic ─┬─▶ turned
        direction ─▶ buffer┘           └─▶ negative ─▶ +- atan 2^-i ─▶ angle ─▶ phi

    A mark passes through the CORDIC with a direction, so that the sign of each of its rotations adds to the angle, one
    a cycle.  The rounding is added before the first.  ``vector`` has priority; a direction enters in the next cycle
    without a vector, when the previous phi has left.

    Resources: a Cordic, an adder.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "vector": In(always_ready_stream(cordic_vector(design))),  # x and y
            "turned": Out(always_ready_stream(cordic_modulus(design))),  # the modulus, ``cordic_latency`` cycles later
            # Fact of the frame; ``cos`` and ``sin`` are looked at.
            "direction": In(stream.Signature(payloads.direction(design))),
            "phi": Out(stream.Signature(unsigned(iterations(design)))),  # one transfer a direction
        })

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
        angle = summed_angle(m, self._design, enter, marks, cordic.negative, waiting.o.p.cos[-1])
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
