"""The front end: words of the converters become codes of the core."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.codes import Codes
from tfra.hdl.front_end.handover import Handover
from tfra.hdl.front_end.intake import ORIGIN, Intake
from tfra.hdl.front_end.ports import EVENTS, FACTS, FAULTY, SETTINGS, TABLES, TAXEL
from tfra.hdl.lib.pipeline import delayed, occupancy, register
from tfra.hdl.lib.streams import Buffer
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import UNITY, check


class FrontEnd(wiring.Component):
    """Checks, calibrates and repairs the frames of the converters.

    Raises ``ValueError`` for converters of fewer than 8 or more than 16 bits.

    Members:
        i: stream in, taxels of a frame row by row; a frame of another length is dropped.
        settings, tables: in, of software.
        tare, simulate: in, pulses.
        time: in, counts cycles.
        codes: stream out, codes of a frame row by row.
        facts: stream out, one transfer a frame, which is taken before the first code.
        events, faulty, faulty_store: out, pulses of a cycle.
        taring: out, frames are averaged for the offsets.
        busy: out, a frame is in the unit.
        skip: in, during a reset: the frame that it cuts goes on afterwards, and its rest is dropped.
    """

    def __init__(self, design: Design) -> None:
        check(design)
        self._design = design
        super().__init__(
            {
                "i": In(stream.Signature(TAXEL)),
                "settings": In(SETTINGS),
                "tare": In(1),
                "simulate": In(1),
                "tables": In(TABLES),
                "time": In(BITS),
                "skip": In(1),
                "codes": Out(stream.Signature(signed(design.adc.bits))),
                "facts": Out(stream.Signature(FACTS)),
                "events": Out(EVENTS),
                "faulty": Out(FAULTY),
                "faulty_store": Out(1),
                "taring": Out(1),
                "busy": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.intake = intake = Intake(self._design.sensor.taxels)
        m.submodules.codes = codes = Codes(self._design)
        m.submodules.handover = handover = Handover(self._design)
        m.submodules.early = early = Buffer(ORIGIN)
        m.submodules.late = late = Buffer(ORIGIN)
        connect(m, flipped(self.i), intake.i)
        connect(m, handover.codes, flipped(self.codes))
        connect(m, handover.o, flipped(self.facts))
        connect(m, early.o, late.i)
        places = occupancy(m, 2, intake.good, handover.done)
        waiting = occupancy(m, 2, delayed(m, intake.good, 8, control=True), handover.done)
        into, out = Signal(), Signal()
        m.d.sync += [into.eq(into ^ intake.good), out.eq(out ^ handover.done)]
        good = register(m, intake.good, "good", control=True)
        m.d.comb += [
            *(getattr(intake, name).eq(getattr(self.settings, name)) for name in ("run", "drop_late", "check_sequence")),
            *(intake.time.eq(self.time), intake.skip.eq(self.skip), intake.room.eq(~places[1])),
            *(early.i.valid.eq(good), early.i.payload.eq(intake.origin)),
            codes.taxel.valid.eq(register(m, intake.entered, control=True)),
            codes.taxel.deviation.eq(
                register(m, intake.word[: self._design.adc.bits].as_signed() << (17 - self._design.adc.bits))
            ),
            *(codes.taxel.gain.eq(UNITY), codes.taxel.index.eq(register(m, intake.index))),
            codes.taxel.page.eq(register(m, into)),
            *(codes.page.eq(out), codes.address.eq(handover.address), codes.read.eq(handover.read)),
            *(handover.stored.eq(codes.stored), handover.waiting.eq(waiting[0]), handover.repaired.eq(1)),
            *(handover.facts.valid.eq(late.o.valid), late.o.ready.eq(handover.facts.ready)),
            *(handover.facts.payload[name].eq(late.o.payload[name]) for name in ("sequence", "user", "started")),
            handover.facts.payload.flags.sequence_gap.eq(late.o.payload.gap),
            *(self.events.accepted.eq(good), self.events.dropped.eq(intake.short | intake.long | intake.late)),
            *(self.events.short_frame.eq(intake.short), self.events.long_frame.eq(intake.long)),
            *(self.events.input_overflow.eq(intake.late), self.events.sequence_gap.eq(intake.gap)),
            self.busy.eq(~intake.idle | places[0]),
        ]
        return m
