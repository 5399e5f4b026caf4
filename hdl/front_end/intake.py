"""Lengths and numbers of frames: complete frames go on, others are dropped whole."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import NUMBER, TAXEL
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.model.fixed.front_end import WORD

ORIGIN = data.StructLayout({"sequence": NUMBER, "user": NUMBER, "started": BITS})
"""Where a frame comes from: FACTS without the faults of its taxels."""


class Intake(wiring.Component):
    """Counts the taxels of a frame up to its last one.

    ========  ==================================================================================================
    WAKE      the cycle after a reset
    IDLE      between frames
    TAKE      in a frame that may become a complete one
    LATE      in a frame that came when there was no room
    LONG      after the last taxel of a frame that goes on
    SKIP      in the rest of a frame that a reset cut
    ========  ==================================================================================================

    A taxel enters in the cycle of its transfer.  With ``drop_late``, the stream only waits between frames while the
    core does not run.  The number of a frame counts whatever its length is, but not that of a frame that a reset cut.

    Members:
        i: stream in.
        run, drop_late, check_sequence: settings.
        time: in, counts cycles.
        room: in, a frame may begin.
        hold: in, taxels have to wait, if they can.
        skip: in, during a reset: the frame that it cuts has not ended.
        entered: a taxel of a frame is taken; ``index``: its number, a register; ``word``.
        idle: no frame is being taken or dropped.
        ended: the frame that was taken ends, and is ``good`` if it is complete.
        origin: of the last complete frame, a cycle later.
        short, long, late: a frame is dropped, a cycle later; ``gap``: a frame's number does not follow the one before.
    """

    def __init__(self, taxels: int) -> None:
        self._taxels = taxels
        settings = dict.fromkeys(("run", "drop_late", "check_sequence", "room", "hold", "skip"), In(1))
        pulses = dict.fromkeys(("entered", "idle", "ended", "good", "short", "long", "late", "gap"), Out(1))
        index = Out(counter_shape(taxels - 1))
        words = {"time": In(BITS), "index": index, "word": Out(WORD), "origin": Out(ORIGIN)}
        super().__init__({"i": In(stream.Signature(TAXEL)), **settings, **pulses, **words})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        transfer = Signal()
        last = Signal()
        skips = Signal()
        index, final = wrapping_counter(m, self.entered, self._taxels, "index")
        with m.If(self.ended):
            m.d.sync += [index.eq(0), final.eq(0)]
        m.d.comb += [
            transfer.eq(self.i.valid & self.i.ready),
            last.eq(transfer & self.i.payload.last),
            self.word.eq(self.i.payload.word),
            self.index.eq(index),
            self.good.eq(self.ended & final),
        ]
        m.d.sync += [self.short.eq(self.ended & ~final), self.long.eq(self.entered & final & ~last), self.late.eq(0)]
        with m.FSM():
            self._wake(m)
            with m.State("IDLE"):
                m.d.comb += [
                    self.idle.eq(~transfer),
                    self.i.ready.eq(self.run & (self.drop_late | (self.room & ~self.hold))),
                    self.entered.eq(transfer & self.room),
                    self.ended.eq(last & self.room),
                ]
                m.d.sync += self.late.eq(last & ~self.room)
                with m.If(transfer & ~last):
                    m.next = "LATE"
                    with m.If(self.room):
                        m.next = "TAKE"
            with m.State("TAKE"):
                ready = self.drop_late | ~self.hold
                m.d.comb += [self.i.ready.eq(ready), self.entered.eq(transfer), self.ended.eq(last)]
                with m.If(transfer & final):
                    m.next = "LONG"
                with m.If(last):
                    m.next = "IDLE"
            with m.State("LATE"):
                m.d.sync += self.late.eq(last)
                self._drop(m, last)
            with m.State("LONG"):
                self._drop(m, last)
            with m.State("SKIP"):
                self._drop(m, last)
                m.d.comb += skips.eq(1)
        self._count(m, last & ~skips)
        return m

    def _wake(self, m: Module) -> None:
        """A reset clears all states; only this register keeps what was asked during it."""
        cut = Signal(reset_less=True)
        m.d.sync += cut.eq(self.skip)
        with m.State("WAKE"):
            m.next = "IDLE"
            with m.If(cut):
                m.next = "SKIP"

    def _drop(self, m: Module, last: Signal) -> None:
        m.d.comb += self.i.ready.eq(1)
        with m.If(last):
            m.next = "IDLE"

    def _count(self, m: Module, arrived: Any) -> None:
        """Numbers of frames, and the origin of the last complete one."""
        sequence = Signal(NUMBER)
        following = Signal(NUMBER, reset_less=True)  # the number that is to come
        known = Signal()
        started = Signal(BITS, reset_less=True)
        origin = Signal(ORIGIN, reset_less=True)
        user = self.i.payload.user
        jumps = arrived & known & (user != following)
        m.d.comb += self.origin.eq(origin)
        m.d.sync += [self.gap.eq(jumps & self.check_sequence), known.eq(self.check_sequence & (known | arrived))]
        with m.If(arrived):
            m.d.sync += [sequence.eq(sequence + 1), following.eq(user + 1)]
        with m.If(self.entered & (self.index == 0)):
            m.d.sync += started.eq(self.time)
        with m.If(self.good):
            m.d.sync += [origin.sequence.eq(sequence), origin.user.eq(user), origin.started.eq(started)]
