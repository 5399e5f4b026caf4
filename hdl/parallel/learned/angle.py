"""Modulus and direction of the tangential force by one run of the CORDIC."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import Cordic, cordic_latency, cordic_modulus, summed_angle
from tfra.hdl.parallel.learned.payloads import angle
from tfra.model.fixed.cordic import ANGLE_GUARD
from tfra.model.fixed.learned.design import LearnedDesign


class Angle(wiring.Component):
    """``(F_x, F_y)`` to its modulus times the CORDIC gain, and phi; the model is
    :func:`tfra.model.fixed.learned.friction.angle`.

    ::

        force -> Cordic -+-> modulus
                         '-> negative -> +- atan 2^-i -> angle

    A mark goes through the CORDIC with a force, so that the sign of each rotation adds to the angle.  A frame at a
    time.  Resources: a Cordic, an adder.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        super().__init__({
            "force": In(always_ready_stream(payloads.total(design))),  # the resultant, one transfer a frame
            # One transfer a frame, ``cordic_latency`` cycles later.
            "modulus": Out(always_ready_stream(cordic_modulus(design))),
            # One transfer a frame, ``angle_latency`` cycles after ``force``; it stays until the next frame.
            "angle": Out(always_ready_stream(angle(design))),
        })

    @property
    def angle_latency(self) -> int:
        """Cycles from the transfer of ``force`` to that of ``angle``: the sum is a register behind the rotations."""
        return cordic_latency(self._design) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.cordic = cordic = Cordic(self._design)
        x, y = self.force.p.words[0], self.force.p.words[1]
        enter = self.force.valid
        marks = Signal(len(cordic.negative))  # bit i: the force is before rotation i
        left = Signal(reset_less=True)
        still = Signal(reset_less=True)
        with m.If(enter):
            m.d.sync += left.eq(x[-1])
            m.d.sync += still.eq(~Cat(x, y).any())
        m.d.sync += marks.eq(Cat(enter, marks))
        total = summed_angle(m, self._design, enter, marks, cordic.negative, left)
        m.d.comb += [
            cordic.vector.valid.eq(enter),
            cordic.vector.p.x.eq(x),
            cordic.vector.p.y.eq(y),
            self.modulus.valid.eq(cordic.turned.valid),
            self.modulus.payload.eq(cordic.turned.payload),
            self.angle.valid.eq(delayed(m, marks[-1], 2, "complete", control=True)),
            self.angle.p.phi.eq(Mux(still, 0, total[ANGLE_GUARD:])),
            self.angle.p.still.eq(still),
        ]
        return m
