"""Beats of the AXI4-Streams, and the taxels in them."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import NUMBER, TAXEL, WORD
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.streams import Spare

OUTPUT = data.StructLayout({"data": BITS, "user": 1, "last": 1})
"""A beat of the output; ``user`` marks the end of a frame that a reset cut."""


def input_beat(taxels: int) -> data.StructLayout:
    """A beat of the input with that many ``taxels``, the first one lowest."""
    return data.StructLayout({"data": WORD * taxels, "user": NUMBER, "last": 1})


class Unpack(wiring.Component):
    """Takes beats apart.

    A frame ends in its last beat at the place where a frame of the right length does; what is behind that is dropped.

    Arguments:
        taxels: of a frame.
        per_beat: taxels in a beat.

    Members: ``i``: stream in, beats; ``o``: stream out, taxels.  Neither ``i.ready`` nor ``o.valid`` depends on an
    input.
    """

    def __init__(self, taxels: int, per_beat: int) -> None:
        self._taxels, self._per_beat = taxels, per_beat
        super().__init__({"i": In(stream.Signature(input_beat(per_beat))), "o": Out(stream.Signature(TAXEL))})

    @property
    def latency(self) -> int:
        """Cycles from a beat to its first taxel."""
        return Spare.latency + (self._per_beat > 1)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.spare = spare = Spare(self.i.payload.shape())
        connect(m, flipped(self.i), spare.i)
        beat, taxel = spare.o.payload, self.o.payload
        if self._per_beat == 1:
            m.d.comb += [taxel.word.eq(beat.data), taxel.user.eq(beat.user), taxel.last.eq(beat.last)]
            m.d.comb += [self.o.valid.eq(spare.o.valid), spare.o.ready.eq(self.o.ready)]
            return m
        held = Signal(beat.shape(), reset_less=True)
        left = Signal(counter_shape(self._per_beat))  # taxels of the beat that are to come
        taken = self.o.valid & self.o.ready
        in_last = (self._taxels - 1) % self._per_beat + 1  # taxels in the last beat of a frame
        m.d.comb += [
            *(taxel.word.eq(held.data), taxel.user.eq(held.user), taxel.last.eq(held.last & (left == 1))),
            *(self.o.valid.eq(left != 0), spare.o.ready.eq((left == 0) | ((left == 1) & self.o.ready))),
        ]
        with m.If(taken):
            m.d.sync += [held.data.eq(held.data >> WORD), left.eq(left - 1)]
        with m.If(spare.o.ready):
            m.d.sync += [held.eq(beat), left.eq(Mux(spare.o.valid, Mux(beat.last, in_last, self._per_beat), 0))]
        return m


class Output(wiring.Component):
    """The last register of the output, which a soft reset does not clear: a frame that it cut is ended by a beat.

    Members: ``i``: stream in; ``o``: stream out, registered; ``cut``: in, high during a soft reset; ``empty``: out.
    """

    def __init__(self) -> None:
        ports = {"i": In(stream.Signature(OUTPUT)), "o": Out(stream.Signature(OUTPUT)), "cut": In(1), "empty": Out(1)}
        super().__init__(ports)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.spare = spare = Spare(OUTPUT)
        connect(m, spare.o, flipped(self.o))
        inside = Signal()  # the last beat that entered is not the end of a frame
        ends = Signal()
        m.d.comb += [
            *(spare.i.valid.eq(self.i.valid | ends), spare.i.payload.eq(self.i.payload)),
            *(self.i.ready.eq(spare.i.ready & ~ends), self.empty.eq(~spare.o.valid)),
        ]
        with m.If(spare.i.valid & spare.i.ready):
            m.d.sync += [inside.eq(~spare.i.payload.last), ends.eq(0)]
        with m.Elif(self.cut):
            m.d.sync += ends.eq(inside)
        with m.If(ends):
            m.d.comb += [spare.i.payload.last.eq(1), spare.i.payload.user.eq(1), spare.i.payload.data.eq(0)]
        return m
