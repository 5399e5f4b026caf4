"""Lengths and numbers of frames: complete frames go on, others are dropped whole; which of them are averaged."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import NUMBER, TAXEL
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import driver, register, wrapping_counter
from tfra.model.fixed.front_end import WORD

ORIGIN = data.StructLayout({"sequence": NUMBER, "user": NUMBER, "started": BITS, "bad": 1})
"""Where a frame comes from: FACTS without the faults of its taxels."""

PART = data.StructLayout({"first": 1, "fresh": 1, "tares": 1, "final": 1})
"""The part of a frame in a mean: its ``first`` or ``final`` frame; ``tares``: a mean for the offsets; ``fresh``: no
frame was before it since the reset."""


class Intake(wiring.Component):
    """Count the taxels of a frame up to its last one.

    ========  ==================================================================================================
    WAKE      the cycle after a reset
    IDLE      between frames
    TAKE      in a frame that may become a complete one
    LATE      in a frame that came when none could begin
    LONG      after the last taxel of a frame that goes on
    SKIP      in the rest of a frame that a reset cut
    ========  ==================================================================================================

    A taxel enters in the cycle of its transfer.  With ``drop_late``, the stream only waits between frames while the
    core does not run.  The number of a frame counts whatever its length is, but not that of a frame that a reset cut.
    """

    def __init__(self, taxels: int) -> None:
        self._taxels = taxels
        super().__init__({
            "i": In(stream.Signature(TAXEL)),
            "run": In(1),  # settings
            "drop_late": In(1),
            "check_sequence": In(1),
            "time": In(BITS),  # counts cycles
            "can_begin": In(1),  # there is a free page for a frame
            "stall": In(1),  # taxels have to wait, if they can
            "skip": In(1),  # during a reset: the frame that it cuts has not ended
            "entered": Out(1),  # a taxel of a frame is taken
            "index": Out(counter_shape(taxels - 1)),  # its number, a register
            "word": Out(WORD),
            "taking": Out(1),  # a frame is being taken, not dropped
            "ended": Out(1),  # the frame that was taken ends ...
            "good": Out(1),  # ... and is complete
            "bad": Out(1),  # the frame that is taken turns out to be too long, or too short and of two taxels at least
            "origin": Out(ORIGIN),  # of the last complete frame, or of a bad one, two cycles later
            "short": Out(1),  # a frame is dropped, a cycle later
            "long": Out(1),
            "late": Out(1),
            "gap": Out(1),  # a frame's number does not follow the one before, two cycles later
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        transfer = self.i.valid & self.i.ready
        last = transfer & self.i.payload.last
        index, final = wrapping_counter(m, self.entered, self._taxels, "index")
        with m.If(self.ended):
            m.d.sync += index.eq(0)
            m.d.sync += final.eq(0)
        m.d.comb += [
            self.word.eq(self.i.payload.word),
            self.index.eq(index),
            self.good.eq(self.ended & final),
        ]
        m.d.sync += [
            self.short.eq(self.ended & ~final),
            self.long.eq(self.entered & final & ~last),
            self.late.eq(0),
        ]
        self._count(m, *self._states(m, transfer, last, final))
        return m

    def _states(self, m: Module, transfer: Value, last: Value, final: Value) -> tuple[Value, Value]:
        """The states; high when a frame ends whose number counts; high between frames."""
        skips = Signal()
        cut = Signal(reset_less=True)  # a reset clears all states; only this register stores what was asked during it
        m.d.sync += cut.eq(self.skip)
        with m.FSM() as states:
            with m.State("WAKE"):
                m.next = "IDLE"
                with m.If(cut):
                    m.next = "SKIP"
            with m.State("IDLE"):
                m.d.comb += [
                    self.taking.eq(self.entered),
                    self.i.ready.eq(self.run & (self.drop_late | (self.can_begin & ~self.stall))),
                    self.entered.eq(transfer & self.can_begin),
                    self.ended.eq(last & self.can_begin),
                ]
                m.d.sync += self.late.eq(last & ~self.can_begin)
                with m.If(transfer & ~last):
                    m.next = "LATE"
                    with m.If(self.can_begin):
                        m.next = "TAKE"
            with m.State("TAKE"):
                m.d.comb += [
                    self.taking.eq(1),
                    self.i.ready.eq(self.drop_late | ~self.stall),
                    self.entered.eq(transfer),
                    self.ended.eq(last),
                    self.bad.eq(transfer & (final ^ self.i.payload.last)),
                ]
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
                m.d.comb += skips.eq(1)
                self._drop(m, last)
        return last & ~skips, states.ongoing("IDLE")

    def _drop(self, m: Module, last: Value) -> None:
        m.d.comb += self.i.ready.eq(1)
        with m.If(last):
            m.next = "IDLE"

    def _count(self, m: Module, arrived: Value, idle: Value) -> None:
        """Numbers of frames, and the origin of the last complete one."""
        sequence = Signal(NUMBER)
        following = Signal(NUMBER, reset_less=True)  # the number that is to come
        known = Signal()
        started = Signal(BITS, reset_less=True)
        origin = driver(m, self.origin)
        user = register(m, self.i.payload.user, "user")
        arrived = register(m, arrived, "arrived", control=True)
        jumps = arrived & known & (user != following)
        m.d.sync += [
            self.gap.eq(jumps & self.check_sequence),
            known.eq(self.check_sequence & (known | arrived)),
        ]
        with m.If(arrived):
            m.d.sync += sequence.eq(sequence + 1)
            m.d.sync += following.eq(user + 1)
        with m.If(idle):
            m.d.sync += started.eq(self.time)
        good = register(m, self.good, "good", control=True)
        m.d.sync += origin.bad.eq(~good)
        with m.If(good):
            m.d.sync += [
                origin.sequence.eq(sequence),
                origin.user.eq(user),
                origin.started.eq(started),
            ]


class Means(wiring.Component):
    """Count the frames of a mean.

    A tare begins between two frames, and drops the mean that is not complete.  After its last frame, no other may come
    until its offsets are written.
    """

    def __init__(self) -> None:
        super().__init__({
            "log2_average": In(3),  # settings: log2 of the frames of a mean, of a tare
            "log2_tare": In(3),
            "tare": In(1),  # pulse
            "between": In(1),  # no frame is being taken, or its last taxel is
            "good": In(1),  # a complete frame ends
            "written": In(1),  # the offsets of a tare are written
            "part": Out(PART),  # of the frame that is being taken, a cycle later
            "taring": Out(1),
            "settling": Out(1),  # no frame may begin
            "completes": Out(1),  # a frame for the core ends
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        number = Signal(7)
        known = Signal()
        requested = Signal()
        part = self.part
        log2 = Mux(self.taring, self.log2_tare, self.log2_average)
        final = Cat(log2 > bit for bit in range(len(number)))  # 2^log2 - 1
        m.d.comb += [
            part.final.eq(register(m, number == final, "final")),
            part.tares.eq(register(m, self.taring, "tares")),
            part.fresh.eq(register(m, ~known, "fresh")),
            part.first.eq(register(m, number == 0, "first")),
            self.completes.eq(self.good & part.final & ~self.taring),
        ]
        with m.If(self.written):
            m.d.sync += self.settling.eq(0)
        with m.If(self.good):
            m.d.sync += number.eq(Mux(part.final, 0, number + 1))
            m.d.sync += known.eq(1)
            with m.If(part.final):
                m.d.sync += self.taring.eq(0)
                m.d.sync += self.settling.eq(self.taring)
        with m.If(self.between & requested):
            m.d.sync += number.eq(0)
            m.d.sync += self.taring.eq(1)
            m.d.sync += requested.eq(0)
        with m.If(self.tare):
            m.d.sync += requested.eq(1)
        return m
