"""Which frames are averaged: for a code, or for the offsets."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

PART = data.StructLayout({"first": 1, "fresh": 1, "tares": 1, "final": 1})
"""The part of a frame in a mean: its ``first`` or ``final`` frame; ``tares``: a mean for the offsets; ``fresh``: no
frame was before it since the reset."""


class Means(wiring.Component):
    """Count the frames of a mean.

    A tare begins between two frames, and drops the mean that is not complete.  After its last frame, no other may come
    until its offsets are written.
    """

    def __init__(self) -> None:
        super().__init__(
            {
                "log2_average": In(3),  # settings: log2 of the frames of a mean, of a tare
                "log2_tare": In(3),
                "tare": In(1),  # pulse
                "between": In(1),  # no frame is being taken, or its last taxel is
                "good": In(1),  # a complete frame ends
                "written": In(1),  # the offsets of a tare are written
                "part": Out(PART),  # of the frame that is being taken; changes after its last taxel
                "taring": Out(1),
                "settling": Out(1),  # no frame may begin
                "completes": Out(1),  # a frame for the core ends
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        number = Signal(7)
        known = Signal()
        requested = Signal()
        part = self.part
        log2 = Mux(self.taring, self.log2_tare, self.log2_average)
        m.d.comb += [
            part.first.eq(number == 0),
            part.final.eq(number == Cat(log2 > bit for bit in range(len(number)))),  # 2^log2 - 1
            part.tares.eq(self.taring),
            part.fresh.eq(~known),
            self.completes.eq(self.good & part.final & ~self.taring),
        ]
        with m.If(self.written):
            m.d.sync += self.settling.eq(0)
        with m.If(self.good):
            m.d.sync += [number.eq(Mux(part.final, 0, number + 1)), known.eq(1)]
            with m.If(part.final):
                m.d.sync += [self.taring.eq(0), self.settling.eq(self.taring)]
        with m.If(self.between & requested):
            m.d.sync += [number.eq(0), self.taring.eq(1), requested.eq(0)]
        with m.If(self.tare):
            m.d.sync += requested.eq(1)
        return m
