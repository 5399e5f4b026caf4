"""The front end: words of the converters become codes of the core."""

from collections.abc import Iterable
from typing import Any

from amaranth import Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.calibrate import Calibrate
from tfra.hdl.front_end.codes import Codes
from tfra.hdl.front_end.faults import Faults
from tfra.hdl.front_end.history import History
from tfra.hdl.front_end.intake import ORIGIN, Intake, Means
from tfra.hdl.front_end.output_reader import OutputReader
from tfra.hdl.front_end.ports import EVENTS, FACTS, FAULTY, SETTINGS, TABLES, TAXEL
from tfra.hdl.front_end.repair import Repair
from tfra.hdl.lib.pipeline import delayed, occupancy, register
from tfra.hdl.lib.streams import Buffer
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import check
from tfra.model.skin.skin import Skin

PAGES = 2
"""Frames whose codes are stored: one that comes, and one that is repaired and leaves."""

_CALIBRATED = 1 + History.latency + Calibrate.latency
"""Cycles from the transfer of a taxel to its deviation, gain and faults."""
_WRITTEN = _CALIBRATED + Codes.latency
"""Cycles from the transfer of a taxel to the one that writes its code."""
_SOON = _WRITTEN - 3
"""Cycles from the transfer of a frame's last taxel to the one from which on it may be read from its first code on."""
_COMPLETE = _CALIBRATED + 1
"""Cycles from the transfer of a frame's last taxel to the pulse of its end, when all its faults are known."""


class FrontEnd(wiring.Component):
    """Check, calibrate and repair the frames of the converters.

    ::

        i ─▶ intake ─▶ history ─▶ calibrate ─▶ codes ─▶ output reader ─▶ codes
                │         ▲           │         ▲ │           │
              means ──────┘         faults      repair        └────────▶ facts

    =======================  ================================================================
    cycle                    taxel
    =======================  ================================================================
    0                        transfer at ``i``
    1 + History.latency      summed; its state is written
    + Calibrate.latency      deviation and gain are at the multiplier, faults are known
    + Codes.latency          its code is written
    =======================  ================================================================

    Raises ``ValueError`` for converters of fewer than 8 or more than 16 bits.
    """

    latency = _SOON + 1 + OutputReader.latency
    """Cycles from the transfer of a frame's last taxel to that of its first code, if nothing is repaired."""
    cut_through = _WRITTEN + OutputReader.latency
    """Cycles from the transfer of a taxel to that of its code, if its frame is cut through."""

    def __init__(self, array: Design | Skin) -> None:
        check(array)
        self._array = array
        taxels = array.sensor.taxels
        self._intake = Intake(taxels)
        self._means = Means()
        self._history = History(taxels)
        self._calibrate = Calibrate(taxels)
        self._codes = Codes(array)
        self._repair = Repair(taxels)
        self._faults = Faults(taxels)
        self._reader = OutputReader(array)
        super().__init__({
            "i": In(stream.Signature(TAXEL)),  # row by row; a frame of another length is dropped
            "settings": In(SETTINGS),
            "tare": In(1),  # pulse
            "simulate": In(1),  # pulse
            "tables": In(TABLES),
            "time": In(BITS),  # counts cycles
            "skip": In(1),  # during a reset: the frame that it cuts goes on afterwards, and its rest is dropped
            "codes": Out(stream.Signature(signed(array.adc.bits))),  # row by row
            "facts": Out(stream.Signature(FACTS)),  # one transfer a frame, after its end
            "events": Out(EVENTS),
            "faulty": Out(FAULTY),
            "faulty_store": Out(1),  # pulse
            "taring": Out(1),  # frames are averaged for the offsets
            "busy": Out(1),  # a frame is in the unit, which settings and tables may change
        })

    def interval(self, words: int, headers: int) -> int:
        """Most cycles from a frame to the next, back to back, with repairs of that many ``words`` and ``headers``.

        A frame is taken while the one before is sent, and waits while that one is repaired.
        """
        return self._array.sensor.taxels + self.latency + Repair.cycles(words, headers)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name in ("intake", "means", "history", "calibrate", "codes", "repair", "faults", "reader"):
            m.submodules[name] = block = getattr(self, f"_{name}")
            _connect(m, self.settings, block, SETTINGS.members.keys() & block.signature.members.keys() - {"run"})
        enabled = self._cut_through(m)
        cut = enabled & self._means.part.final & ~self._means.taring
        leaves = self._means.completes | (self._intake.bad & cut)
        completes, turn = self._ends(m)
        busy = occupancy(m, PAGES, leaves, self._reader.done)
        self._receive(m, busy, turn)
        self._calibrate_taxels(m, turn)
        self._store_codes(m, cut, leaves)
        self._send(m, enabled, leaves)
        self._report(m, completes)
        return m

    def _cut_through(self, m: Module) -> Value:
        """Whether frames go on while they come; it changes while no frame is there, when the repair of none is done."""
        settings = self.settings
        enabled = Signal()
        with m.If(~self.busy):
            m.d.sync += enabled.eq(settings.cut_through & ~settings.contact.any() & self._repair.repaired)
        return enabled

    def _ends(self, m: Module) -> tuple[Value, Value]:
        """Pulses when all faults of a frame are known: it completes one for the core; it completes a tare."""
        part = self._means.part
        tared = self._intake.good & self._means.taring & part.final
        completes = delayed(m, self._means.completes, _COMPLETE, "completes", control=True)
        return completes, delayed(m, tared, _COMPLETE, "turn", control=True)

    def _receive(self, m: Module, busy: Value, turn: Value) -> None:
        """Taxels enter while there is a page for their frame; means tell which frames belong together."""
        intake, means, reader = self._intake, self._means, self._reader
        connect(m, flipped(self.i), intake.i)
        _connect(m, self, intake, ("time", "skip"))
        m.d.comb += [
            intake.run.eq(delayed(m, self.settings.run, 2, "run", control=True)),  # after what depends on the others
            intake.can_begin.eq(~busy[-1] & ~means.settling),
            intake.stall.eq(register(m, reader.repair & ~self._repair.repaired, "stall", control=True)),
            means.tare.eq(self.tare),
            means.between.eq(~intake.taking | intake.ended),
            means.good.eq(intake.good),
            means.written.eq(turn),
            self.taring.eq(means.taring),
            self.busy.eq(intake.taking | busy[0] | means.settling),
        ]

    def _calibrate_taxels(self, m: Module, turn: Value) -> None:
        """A taxel's sum over the frames of a mean becomes its deviation, with its gain."""
        history, intake = self._history, self._intake
        connect(m, flipped(self.tables), self._calibrate.software)
        m.d.comb += [
            history.entered.eq(register(m, intake.entered, "entered", control=True)),
            history.index.eq(register(m, intake.index, "index")),
            history.word.eq(register(m, intake.word, "word")),
            history.good.eq(register(m, intake.good, "good", control=True)),
            history.part.eq(self._means.part),
            self._calibrate.i.eq(history.o),
            self._calibrate.turn.eq(turn),
        ]

    def _store_codes(self, m: Module, cut: Value, leaves: Value) -> None:
        """Codes of taxels are stored; those of the frame that leaves are repaired, then read."""
        codes, repair, reader, calibrate = self._codes, self._repair, self._reader, self._calibrate
        page_in = Signal()  # of the frame that comes
        page_out = Signal()  # of the frame that leaves
        m.d.sync += [
            page_in.eq(page_in ^ leaves),
            page_out.eq(page_out ^ reader.done),
        ]
        m.d.comb += [
            codes.taxel.eq(calibrate.o),
            codes.taxel.page.eq(delayed(m, page_in, _CALIBRATED, "page")),
            codes.term.eq(repair.term),
            codes.page.eq(page_out),
            codes.address.eq(Mux(reader.repair, repair.source, reader.address)),
            codes.read.eq(reader.repair | reader.read),
            repair.active.eq(reader.repair),
            repair.blocked.eq(self._history.o.valid),
            repair.settles.eq(codes.settles),
            repair.write.eq(calibrate.repair),
            repair.place.eq(calibrate.repair_place),
            repair.data.eq(self.tables.data),
            calibrate.repair_word.eq(repair.stored),
            codes.spoils.eq(delayed(m, self._intake.bad & cut, _WRITTEN, "spoils", control=True)),
            reader.cut.eq(delayed(m, cut, _WRITTEN, "cut", control=True)),
            reader.written.eq(codes.written),
            reader.silent.eq(~codes.reached.bit_select(page_out, 1)),
        ]

    def _send(self, m: Module, enabled: Value, leaves: Value) -> None:
        """The facts of a frame that leaves, and its codes.

        As many facts wait as there are pages of codes; the origin is known before the flags.
        """
        reader, intake = self._reader, self._intake
        complete = delayed(m, leaves, 2, "complete", control=True)
        ends = delayed(m, complete, _COMPLETE - 2, "complete", control=True)
        soon = delayed(m, ends, _SOON - _COMPLETE, "complete", control=True)
        written = delayed(m, soon, _WRITTEN - _SOON, "complete", control=True)
        origin = self._wait(m, complete, intake.origin, "origin")
        flags = self._wait(m, ends, self._faults.flags, "flags")
        waiting = occupancy(m, PAGES, Mux(enabled, written, soon), reader.done)
        taken = self.facts.valid & self.facts.ready
        connect(m, reader.codes, flipped(self.codes))
        m.d.comb += [
            reader.waiting.eq(waiting[0]),
            reader.repaired.eq(self._repair.repaired),
            reader.stored.eq(self._codes.stored),
            self.facts.payload.flags.eq(flags.payload),
            self.facts.valid.eq(origin.valid & flags.valid),
            origin.ready.eq(taken),
            flags.ready.eq(taken),
        ]
        m.d.comb += [self.facts.payload[name].eq(origin.payload[name]) for name, _ in ORIGIN]

    @staticmethod
    def _wait(m: Module, valid: Value, payload: Any, name: str) -> Any:
        """A stream that stores one transfer for each page."""
        first, second = Buffer(payload.shape()), Buffer(payload.shape())
        m.submodules[f"{name}_first"], m.submodules[f"{name}_second"] = first, second
        connect(m, first.o, second.i)
        m.d.comb += [
            first.i.valid.eq(valid),
            first.i.payload.eq(payload),
        ]
        return second.o

    def _report(self, m: Module, completes: Value) -> None:
        """Faults of a frame when its last taxel is calibrated; events of the intake at once."""
        faults, intake, calibrate = self._faults, self._intake, self._calibrate
        tares = intake.good & self._means.taring
        _connect(m, faults, self, ("faulty", "faulty_store"))
        m.d.comb += [
            faults.taxel.eq(calibrate.o.valid),
            faults.index.eq(calibrate.o.index),
            faults.faults.eq(calibrate.faults),
            faults.simulate.eq(self.simulate),
            faults.end.eq(delayed(m, intake.good, _COMPLETE, "end", control=True)),
            faults.gap.eq(delayed(m, intake.gap, _COMPLETE - 2, "gap", control=True)),
            faults.completes.eq(completes),
            faults.tares.eq(delayed(m, tares, _COMPLETE, "tares")),
            self.events.accepted.eq(register(m, intake.good, "accepted", control=True)),
            self.events.dropped.eq(intake.short | intake.long | intake.late),
            self.events.short_frame.eq(intake.short),
            self.events.long_frame.eq(intake.long),
            self.events.input_overflow.eq(intake.late),
            self.events.sequence_gap.eq(intake.gap),
            self.events.saturation.eq(faults.events.saturated),
            self.events.stuck.eq(faults.events.stuck),
            self.events.out_of_range.eq(faults.events.out_of_range),
        ]


def _connect(m: Module, source: Any, target: Any, names: Iterable[str]) -> None:
    """Connect ports that have the same names on either side."""
    m.d.comb += [getattr(target, name).eq(getattr(source, name)) for name in names]
