"""The wrapper: buses, registers and front end around a core, which stays outside of it."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, ResetInserter, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.axi_lite import bus
from tfra.hdl.bus.map import BITS, RegisterMap
from tfra.hdl.bus.registers import Registers
from tfra.hdl.front_end.ports import EVENTS, FAULTY, FLAGS, SETTINGS
from tfra.hdl.front_end.unit import FrontEnd
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.interface.ports import coefficient, result, taxel
from tfra.hdl.ip.beats import OUTPUT, Output, Unpack, input_beat
from tfra.hdl.ip.crc import Crc32
from tfra.hdl.ip.framer import Framer
from tfra.hdl.ip.load import Load
from tfra.hdl.lib.pipeline import register

RESET = 8
"""Cycles of a reset of the core, so that its wires may be slow."""

_SETTINGS = {
    "run": "CONTROL.run",
    "drop_late": "CONTROL.drop_late",
    "check_sequence": "CONTROL.check_sequence",
    "word_bits": "FRONT_END.word_bits",
    "is_unsigned": "FRONT_END.is_unsigned",
    "invert": "FRONT_END.invert",
    "log2_average": "FRONT_END.log2_average",
    "log2_tare": "TARE.log2_frames",
    "dead_band": "THRESHOLDS.dead_band",
    "contact": "THRESHOLDS.contact",
    "stuck_frames": "STUCK.frames",
    "repair_words": "REPAIRS.words",
}
"""The field of each of SETTINGS."""


class Wrapper(wiring.Component):
    """Everything of an IP core but the core.

    A soft reset lasts ``RESET`` cycles.  It clears neither the registers nor the bus, and the streams' last stages
    stay: a frame that it cuts at the output is ended by a beat with ``user`` set, the rest of one that it cuts at the
    input is skipped.

    Arguments:
        core: what the core is, without building it.
        registers: the map, with the values of this design.

    Members:
        bus: AXI4-Lite; ``interrupt``: out, a level.
        frames: stream in, beats with taxels; ``results``: stream out.
        reset: out, of the core.
        taxel: stream out, ``result``: stream in, ``load``: stream out, if the core is loaded: the core's.

    Raises ``ValueError`` for a design whose words do not fit the streams.
    """

    def __init__(self, core: Microarchitecture, registers: RegisterMap) -> None:
        design = core.design
        self._core, self._map, self._design = core, registers, design
        self._front_end = FrontEnd(design)
        errors = {field.name: field.low for field in registers["ERRORS"].fields}
        self._framer = Framer(design, {name: errors[name] for name, _ in FLAGS})
        loads = {} if core.loaded is None else {"load": Out(stream.Signature(coefficient(design)))}
        super().__init__(
            {
                "bus": In(bus(registers.address_bits)),
                "interrupt": Out(1),
                "frames": In(stream.Signature(input_beat(design.bus.taxels_per_beat))),
                "results": Out(stream.Signature(OUTPUT)),
                "reset": Out(1),
                "taxel": Out(stream.Signature(taxel(design))),
                "result": In(stream.Signature(result(design))),
                **loads,
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.registers = registers = Registers(self._map)
        connect(m, flipped(self.bus), registers.bus)
        hardware = registers.hardware
        m.d.comb += self.interrupt.eq(registers.interrupt)
        resets = self._resets(m, hardware.CONTROL.soft_reset)
        time = Signal(BITS)
        m.d.sync += time.eq(time + 1)
        self._streams(m, hardware, resets, time)
        self._tables(m, hardware)
        self._load(m, hardware, resets)
        self._tell(m, hardware)
        return m

    def _resets(self, m: Module, pulse: Value) -> Signal:
        """High for ``RESET`` cycles, also after a reset of everything."""
        left = Signal(range(RESET + 1), init=RESET)
        resets = Signal(init=1)
        with m.If(pulse):
            m.d.sync += [left.eq(RESET), resets.eq(1)]
        with m.Else():
            m.d.sync += [left.eq(Mux(left == 0, 0, left - 1)), resets.eq(left > 1)]
        m.d.comb += self.reset.eq(resets)
        return resets

    def _streams(self, m: Module, hardware: Any, resets: Signal, time: Signal) -> None:
        unpack = Unpack(self._design.sensor.taxels, self._design.bus.taxels_per_beat)
        m.submodules.unpack = unpack = ResetInserter(resets)(unpack)
        m.submodules.front_end = front_end = ResetInserter(resets)(self._front_end)
        m.submodules.framer = framer = ResetInserter(resets)(self._framer)
        m.submodules.output = output = Output()
        inside = Signal()  # the last beat that came is not the end of a frame
        frames = self.frames
        with m.If(frames.valid & frames.ready):
            m.d.sync += inside.eq(~frames.payload.last)
        m.d.comb += [
            *(unpack.i.payload.eq(frames.payload), unpack.i.valid.eq(frames.valid & ~resets)),
            *(frames.ready.eq(unpack.i.ready & ~resets), front_end.skip.eq(inside)),
            *(front_end.time.eq(time), framer.time.eq(time), output.cut.eq(resets)),
            *(front_end.tare.eq(hardware.CONTROL.tare), front_end.simulate.eq(hardware.CONTROL.simulate_error)),
            framer.taxel_forces.eq(hardware.CONTROL.taxel_forces),
        ]
        for name in SETTINGS.members:
            owner, field = _SETTINGS[name].split(".")
            m.d.comb += getattr(front_end.settings, name).eq(getattr(getattr(hardware, owner), field))
        connect(m, unpack.o, front_end.i)
        connect(m, front_end.codes, flipped(self.taxel))
        connect(m, front_end.facts, framer.facts)
        connect(m, flipped(self.result), framer.result)
        connect(m, framer.o, output.i)
        connect(m, output.o, flipped(self.results))

    def _tables(self, m: Module, hardware: Any) -> None:
        m.submodules.calibration = crc = Crc32()
        tables, place, written = m.submodules.front_end.tables, hardware.CALIBRATION_PLACE, hardware.CALIBRATION_DATA
        m.d.comb += [
            *(tables.place_written.eq(place.index_written), tables.index.eq(place.index), tables.kind.eq(place.kind)),
            *(tables.data_written.eq(written.word_written), tables.data.eq(written.word)),
            *(crc.clear.eq(place.index_written), crc.word.eq(written.word), crc.written.eq(written.word_written)),
            hardware.CALIBRATION_VALUE.word.eq(tables.value),
            hardware.CALIBRATION_CRC.crc.eq(crc.crc),
        ]

    def _load(self, m: Module, hardware: Any, resets: Signal) -> None:
        words = self._core.loaded
        if words is None:
            m.d.comb += hardware.STATUS.loaded.eq(1)
            return
        m.submodules.load = load = ResetInserter(resets)(Load(self.load.payload.shape(), words.size))
        connect(m, load.o, flipped(self.load))
        m.d.comb += [
            *(load.word.eq(hardware.LOAD_DATA.word), load.written.eq(hardware.LOAD_DATA.word_written & ~resets)),
            *(load.expected.eq(hardware.LOAD_CHECKSUM.crc), hardware.LOAD_CRC.crc.eq(load.crc)),
            *(hardware.LOAD_STATUS.ready.eq(load.ready & ~resets), hardware.LOAD_STATUS.match.eq(load.match)),
            *(hardware.LOAD_COUNT.words_up.eq(load.count), hardware.STATUS.loaded.eq(load.loaded)),
            *(hardware.ERRORS.load_checksum_set.eq(load.wrong), hardware.INTERRUPT_STATUS.loaded_set.eq(load.done)),
        ]

    def _tell(self, m: Module, hardware: Any) -> None:
        """Status, errors, counters and interrupts."""
        front_end, framer, output = (m.submodules[name] for name in ("front_end", "framer", "output"))
        events, errors = front_end.events, hardware.ERRORS
        counted = {"accepted", "dropped", "saturation"}
        m.d.comb += [getattr(errors, f"{name}_set").eq(getattr(events, name)) for name in EVENTS.members if name not in counted]
        faulty = hardware.FAULTY_TAXEL
        for name, _ in FAULTY:
            m.d.comb += [getattr(faulty, name).eq(front_end.faulty[name]), getattr(faulty, f"{name}_store").eq(front_end.faulty_store)]
        sets = [getattr(errors, f"{field.name}_set") for field in self._map["ERRORS"].fields]
        m.d.comb += [
            errors.saturation_set.eq(events.saturation | framer.limited),
            errors.simulated_set.eq(hardware.CONTROL.simulate_error),
            errors.stale_set.eq(self._stale(m, hardware, events.accepted)),
            hardware.INTERRUPT_STATUS.error_set.eq(Cat(sets).any()),
            hardware.INTERRUPT_STATUS.frame_set.eq(
                self.results.valid & self.results.ready & self.results.payload.last & ~self.results.payload.user
            ),
            *(hardware.FRAMES_IN.count_up.eq(events.accepted), hardware.FRAMES_DROPPED.count_up.eq(events.dropped)),
            *(hardware.FRAMES_OUT.count_up.eq(framer.done), hardware.FRAMES_SATURATED.count_up.eq(framer.saturated)),
            *(hardware.FRAME_CYCLES.cycles.eq(framer.cycles), hardware.FRAME_CYCLES.cycles_store.eq(framer.done)),
            *(hardware.STATUS.running.eq(hardware.CONTROL.run), hardware.STATUS.taring.eq(front_end.taring)),
            hardware.STATUS.busy.eq(register(m, front_end.busy | framer.frames | ~output.empty, "busy", control=True)),
        ]

    @staticmethod
    def _stale(m: Module, hardware: Any, accepted: Value) -> Signal:
        """A pulse when no frame came for the stated cycles; then they begin anew."""
        cycles = hardware.FRAME_TIMEOUT.cycles
        left = Signal(BITS, reset_less=True)
        stale = Signal()
        over = left == 0
        m.d.sync += stale.eq(hardware.CONTROL.run & (cycles != 0) & over & ~accepted)
        m.d.sync += left.eq(Mux(hardware.CONTROL.run & ~accepted & ~over, left - 1, cycles))
        return stale
