"""Which frames are averaged: for a code, or for the offsets."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

PART = data.StructLayout({"first": 1, "fresh": 1, "tares": 1, "final": 1})
"""What a frame is of a mean: its first frame, its last one, one for the offsets; ``fresh``: no frame was before it."""


class Means(wiring.Component):
    """Counts the frames of a mean.

    A tare begins between two frames, and drops the mean that is not complete.  After its last frame, no other may come
    until its offsets are written.

    Members:
        log2_average, log2_tare: settings.
        tare: in, pulse.
        between: in, no frame is being taken, or its last taxel is; ``good``: in, a complete frame ends.
        written: in, the offsets of a tare are written.
        part: of the frame that is being taken; it changes after the last taxel.
        taring: out; ``settling``: out, no frame may begin.
        completes: out, a frame for the core ends.
    """

    def __init__(self) -> None:
        inputs = dict.fromkeys(("tare", "between", "good", "written"), In(1))
        outputs = dict.fromkeys(("taring", "settling", "completes"), Out(1))
        super().__init__({"log2_average": In(3), "log2_tare": In(3), **inputs, "part": Out(PART), **outputs})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        number = Signal(7)
        known = Signal()
        asked = Signal()
        part = self.part
        log2 = Mux(self.taring, self.log2_tare, self.log2_average)
        m.d.comb += [
            part.first.eq(number == 0),
            part.final.eq(number == Cat(log2 > place for place in range(len(number)))),
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
        with m.If(self.between & asked):
            m.d.sync += [number.eq(0), self.taring.eq(1), asked.eq(0)]
        with m.If(self.tare):
            m.d.sync += asked.eq(1)
        return m
