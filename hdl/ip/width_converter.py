"""Beats of several taxels become taxels."""

from typing import Any

from amaranth import Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.ports import NUMBER, TAXEL
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.model.fixed.front_end import WORD


def input_beat(taxels: int) -> data.StructLayout:
    """``taxels`` of an input frame, the first one lowest; ``last`` ends the frame, ``user`` is then its number."""
    return data.StructLayout({"words": data.ArrayLayout(WORD, taxels), "user": NUMBER, "last": 1})


class WidthConverter(wiring.Component):
    """One taxel a cycle, without the lanes of a complete frame's last beat that are beyond the last of its ``taxels``.

    A single taxel a beat passes as it is.  Several, ``per_beat``, come from a register, and the next beat is taken with
    the last of them.
    """

    def __init__(self, taxels: int, per_beat: int) -> None:
        self._per_beat = per_beat
        self._beats = -(-taxels // per_beat)  # of a complete frame
        self._last_lane = (taxels - 1) % per_beat  # in the last of these beats
        super().__init__({
            "i": In(stream.Signature(input_beat(per_beat))),
            "o": Out(stream.Signature(TAXEL)),
            "restart": In(1),  # the beat is forgotten and none is taken
            "cut": Out(1),  # the frame of the last beat that was taken has not ended; a register
        })

    @staticmethod
    def latency(taxels: int, per_beat: int) -> int:
        """Cycles from the transfer of a complete frame's last beat to that of its last taxel."""
        return 1 + (taxels - 1) % per_beat if per_beat > 1 else 0

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = self.i.valid & self.i.ready
        with m.If(taken):
            m.d.sync += self.cut.eq(~self.i.p.last)
        if self._per_beat > 1:
            self._convert(m, taken)
        else:
            self._pass(m)
        return m

    def _pass(self, m: Module) -> None:
        """A beat is a taxel."""
        m.d.comb += [
            self.o.p.word.eq(self.i.p.words[0]),
            self.o.p.user.eq(self.i.p.user),
            self.o.p.last.eq(self.i.p.last),
            self.o.valid.eq(self.i.valid),
            self.i.ready.eq(self.o.ready & ~self.restart),
        ]

    def _convert(self, m: Module, taken: Value) -> None:
        """The lanes of a beat, one by one."""
        beat = Signal(self.i.p.shape(), reset_less=True)
        full = Signal()
        lane = Signal(range(self._per_beat), reset_less=True)
        last_lane = Signal(range(self._per_beat), reset_less=True)
        last = Signal()
        number = Signal(counter_shape(self._beats - 1))  # of the beat to come in its frame; stays at the last one
        final = self.i.p.last & (number == self._beats - 1)
        m.d.comb += [
            last.eq(lane == last_lane),
            self.i.ready.eq((~full | (last & self.o.ready)) & ~self.restart),
            self.o.valid.eq(full),
            self.o.p.word.eq(beat.words[lane]),
            self.o.p.user.eq(beat.user),
            self.o.p.last.eq(beat.last & last),
        ]
        with m.If(full & self.o.ready):
            m.d.sync += [
                lane.eq(lane + 1),
                full.eq(~last),
            ]
        with m.If(taken):
            m.d.sync += [
                beat.eq(self.i.p),
                full.eq(1),
                lane.eq(0),
                last_lane.eq(Mux(final, self._last_lane, self._per_beat - 1)),
                number.eq(Mux(self.i.p.last, 0, number + (number != self._beats - 1))),
            ]
        with m.If(self.restart):
            m.d.sync += full.eq(0)
