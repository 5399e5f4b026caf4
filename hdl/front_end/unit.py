"""The front end: words of the converters become codes of the core."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.calibrate import Calibrate
from tfra.hdl.front_end.codes import FETCH, Codes
from tfra.hdl.front_end.faults import Faults
from tfra.hdl.front_end.handover import Handover
from tfra.hdl.front_end.history import History
from tfra.hdl.front_end.intake import ORIGIN, Intake
from tfra.hdl.front_end.means import Means
from tfra.hdl.front_end.ports import EVENTS, FACTS, FAULTY, SETTINGS, TABLES, TAXEL
from tfra.hdl.front_end.repair import Repair
from tfra.hdl.lib.pipeline import delayed, occupancy, register
from tfra.hdl.lib.streams import Buffer
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import check


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

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a frame's last taxel to that of its first code, if nothing is repaired."""
        return History.latency + Calibrate.latency + 2 + Handover.latency

    def interval(self, words: int, headers: int) -> int:
        """Most cycles from a frame to the next, back to back, with repairs of that many ``words`` and ``headers``.

        A frame is taken while the one before is handed over, and waits while that one is repaired.
        """
        return self._design.sensor.taxels + self.latency + Repair.cycles(words, headers)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taxels = self._design.sensor.taxels
        m.submodules.intake = intake = Intake(taxels)
        m.submodules.means = means = Means()
        m.submodules.history = history = History(taxels)
        m.submodules.calibrate = calibrate = Calibrate(taxels)
        m.submodules.codes = codes = Codes(self._design)
        m.submodules.repair = repair = Repair(taxels)
        m.submodules.handover = handover = Handover(self._design)
        connect(m, flipped(self.i), intake.i)
        connect(m, handover.codes, flipped(self.codes))
        connect(m, handover.o, flipped(self.facts))
        connect(m, flipped(self.tables), calibrate.software)
        self._set(m, intake, means, history, calibrate, codes, repair)
        completes, turn = self._ends(m, intake, means, calibrate, handover)
        into, out = Signal(), Signal()  # pages of the frame that comes, and of the one that leaves
        m.d.sync += [into.eq(into ^ means.completes), out.eq(out ^ handover.done)]
        places = occupancy(m, 2, means.completes, handover.done)
        waiting = occupancy(m, 2, completes, handover.done)
        page = delayed(m, into, History.latency + Calibrate.latency, "page")
        m.d.comb += [
            *(intake.time.eq(self.time), intake.skip.eq(self.skip), means.tare.eq(self.tare)),
            *(intake.room.eq(~places[1] & ~means.settling), intake.hold.eq(handover.repair & ~repair.repaired)),
            *(means.between.eq(intake.idle | intake.ended), means.good.eq(intake.good), means.written.eq(turn)),
            *(history.entered.eq(intake.entered), history.index.eq(intake.index), history.word.eq(intake.word)),
            *(history.part.eq(means.part), history.good.eq(intake.good)),
            *(calibrate.i.eq(history.o), calibrate.turn.eq(turn)),
            *(codes.taxel.eq(calibrate.o), codes.taxel.page.eq(page), codes.term.eq(repair.term), codes.page.eq(out)),
            codes.address.eq(Mux(handover.repair, repair.source, handover.address)),
            codes.read.eq(handover.repair | handover.read),
            *(repair.active.eq(handover.repair), handover.repaired.eq(repair.repaired)),
            repair.blocked.eq(delayed(m, history.o.valid, Calibrate.latency - FETCH, "blocked", control=True)),
            *(repair.write.eq(calibrate.repair), repair.place.eq(calibrate.repair_place)),
            repair.data.eq(self.tables.data),
            *(handover.stored.eq(codes.stored), handover.waiting.eq(waiting[0])),
            handover.silent.eq(~codes.reached.bit_select(out, 1)),
            *(self.taring.eq(means.taring), self.busy.eq(~intake.idle | places[0] | means.settling)),
        ]
        return m

    def _set(self, m: Module, *blocks: Any) -> None:
        """Settings and all that has the name of a port of the unit."""
        own, names = self.settings, set(SETTINGS.members)
        for block in blocks:
            m.d.comb += [getattr(block, name).eq(getattr(own, name)) for name in names & set(block.signature.members)]

    def _ends(self, m: Module, intake: Intake, means: Means, calibrate: Calibrate, handover: Handover) -> Any:
        """What happens at the end of a frame: events, facts; the ends of a frame for the core and of a tare, in time.

        Facts wait in two places, as many as there are pages of codes: the origin is known before the flags.
        """
        m.submodules.faults = faults = Faults(self._design.sensor.taxels)
        later = History.latency + Calibrate.latency + 1  # all faults of the frame are known
        tares = intake.good & means.part.tares
        completes = delayed(m, means.completes, later, "completes", control=True)
        turn = delayed(m, tares & means.part.final, later, "turn", control=True)
        m.d.comb += [
            *(faults.taxel.eq(calibrate.o.valid), faults.index.eq(calibrate.o.index)),
            *(faults.faults.eq(calibrate.faults), faults.simulate.eq(self.simulate)),
            faults.end.eq(delayed(m, intake.good, later, "end", control=True)),
            *(faults.completes.eq(completes), faults.tares.eq(delayed(m, tares, later, "tares"))),
            faults.gap.eq(delayed(m, intake.gap, later - 1, "gap", control=True)),
            *(self.faulty.eq(faults.faulty), self.faulty_store.eq(faults.faulty_store)),
            self.events.accepted.eq(register(m, intake.good, "accepted", control=True)),
            self.events.dropped.eq(intake.short | intake.long | intake.late),
            *(self.events.short_frame.eq(intake.short), self.events.long_frame.eq(intake.long)),
            *(self.events.input_overflow.eq(intake.late), self.events.sequence_gap.eq(intake.gap)),
            *(self.events.saturation.eq(faults.events.saturated), self.events.stuck.eq(faults.events.stuck)),
            self.events.out_of_range.eq(faults.events.out_of_range),
        ]
        origin = self._two(m, register(m, means.completes, "completes", control=True), intake.origin, "origin")
        flags = self._two(m, completes, faults.flags, "flags")
        taken = handover.facts.valid & handover.facts.ready
        m.d.comb += [
            *(handover.facts.payload[name].eq(origin.payload[name]) for name, _ in ORIGIN),
            handover.facts.payload.flags.eq(flags.payload),
            handover.facts.valid.eq(origin.valid & flags.valid),
            *(origin.ready.eq(taken), flags.ready.eq(taken)),
        ]
        return completes, turn

    @staticmethod
    def _two(m: Module, valid: Value, payload: Any, name: str) -> Any:
        """A stream that holds two transfers."""
        first, second = Buffer(payload.shape()), Buffer(payload.shape())
        m.submodules[f"{name}_first"], m.submodules[f"{name}_second"] = first, second
        connect(m, first.o, second.i)
        m.d.comb += [first.i.valid.eq(valid), first.i.payload.eq(payload)]
        return second.o
