"""Beats of several taxels become taxels."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.ports import TAXEL
from tfra.hdl.ip.ports import beat
from tfra.hdl.lib.arithmetic import counter_shape


class Unpack(wiring.Component):
    """One taxel a cycle, without those places of a complete frame's last beat that are beyond its last taxel.

    A single taxel a beat passes as it is.  Several come from a register, and the next beat is taken with the last of
    them.

    ``latency`` counts cycles from the transfer of a complete frame's last beat to that of its last taxel.

    Arguments: ``taxels``: of a frame; ``per_beat``: taxels of a beat.

    Members: ``i``: beats in; ``o``: taxels out; ``restart``: in, the beat is forgotten and none is taken; ``cut``: the
    frame of the last beat that was taken has not ended, a register.
    """

    def __init__(self, taxels: int, per_beat: int) -> None:
        self._beats, self._remainder = -(-taxels // per_beat), (taxels - 1) % per_beat
        self._per_beat = per_beat
        streams = {"i": In(stream.Signature(beat(per_beat))), "o": Out(stream.Signature(TAXEL))}
        super().__init__({**streams, "restart": In(1), "cut": Out(1)})

    @property
    def latency(self) -> int:
        return 1 + self._remainder if self._per_beat > 1 else 0

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = self.i.valid & self.i.ready
        with m.If(taken):
            m.d.sync += self.cut.eq(~self.i.p.last)
        if self._per_beat > 1:
            self._one_by_one(m, taken)
            return m
        m.d.comb += [
            *(self.o.p.word.eq(self.i.p.words[0]), self.o.p.user.eq(self.i.p.user), self.o.p.last.eq(self.i.p.last)),
            *(self.o.valid.eq(self.i.valid), self.i.ready.eq(self.o.ready & ~self.restart)),
        ]
        return m

    def _one_by_one(self, m: Module, taken: Any) -> None:
        held = Signal(self.i.p.shape(), reset_less=True)
        full = Signal()
        place, end = (Signal(range(self._per_beat), name=name, reset_less=True) for name in ("place", "end"))
        beats = Signal(counter_shape(self._beats - 1))  # beats of the frame before this one; stays at its end
        last = Signal()
        m.d.comb += [
            last.eq(place == end),
            self.i.ready.eq((~full | (last & self.o.ready)) & ~self.restart),
            *(self.o.valid.eq(full), self.o.p.word.eq(held.words[place])),
            *(self.o.p.user.eq(held.user), self.o.p.last.eq(held.last & last)),
        ]
        with m.If(full & self.o.ready):
            m.d.sync += [place.eq(place + 1), full.eq(~last)]
        with m.If(taken):
            complete = self.i.p.last & (beats == self._beats - 1)
            m.d.sync += [held.eq(self.i.p), full.eq(1), place.eq(0)]
            m.d.sync += end.eq(Mux(complete, self._remainder, self._per_beat - 1))
            m.d.sync += beats.eq(Mux(self.i.p.last, 0, beats + (beats != self._beats - 1)))
        with m.If(self.restart):
            m.d.sync += full.eq(0)
