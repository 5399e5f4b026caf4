"""What the registers mean: settings, commands, events and counters of the blocks around the core."""

from operator import attrgetter
from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS, RegisterMap
from tfra.hdl.bus.registers import hardware
from tfra.hdl.front_end.ports import EVENTS, FAULTY, SETTINGS, TABLES
from tfra.hdl.ip.load import LOADING, Crc
from tfra.hdl.lib.pipeline import register

_SETTINGS = {
    "run": "CONTROL.run",
    "drop_late": "CONTROL.drop_late",
    "check_sequence": "CONTROL.check_sequence",
    "cut_through": "CONTROL.cut_through",
    "word_bits": "FRONT_END.word_bits",
    "is_unsigned": "FRONT_END.is_unsigned",
    "invert": "FRONT_END.invert",
    "log2_average": "FRONT_END.log2_average",
    "log2_tare": "TARE.log2_frames",
    "stuck_frames": "STUCK.frames",
    "repair_words": "REPAIRS.words",
    "dead_band": "THRESHOLDS.dead_band",
    "contact": "THRESHOLDS.contact",
}
"""Settings of the front end, and their fields."""

_EVENTS = ("short_frame", "long_frame", "input_overflow", "sequence_gap", "out_of_range", "stuck")
"""Events of the front end that are errors of the same name."""


class Control(wiring.Component):
    """Between the ports of the ``registers`` and the blocks."""

    def __init__(self, registers: RegisterMap) -> None:
        super().__init__({
            "hardware": In(hardware(registers)),  # of the registers
            "settings": Out(SETTINGS),
            "tables": Out(TABLES),
            "loading": Out(LOADING),
            "restart": Out(1, init=1),  # a soft reset, and the first cycle after the reset; a register
            "tare": Out(1),  # pulses of CONTROL
            "simulate": Out(1),
            "taxel_forces": Out(1),  # setting: output frames have the forces at the taxels
            "time": Out(BITS),  # counts cycles
            "events": In(EVENTS),  # of the front end
            "faulty": In(FAULTY),
            "faulty_store": In(1),
            "taring": In(1),
            "saturated": In(1),  # pulse: a result that ends reports saturation
            "ended": In(1),  # pulse: the last word of an output frame is taken ...
            "started": In(BITS),  # ... whose first taxel came at this time
            "calibrating": In(1),  # a frame is in the front end
            "busy": In(1),  # a frame is in the blocks or the core
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        control, status = self.hardware.CONTROL, self.hardware.STATUS
        m.d.sync += [
            self.restart.eq(control.soft_reset),
            self.time.eq(self.time + 1),
        ]
        for name, path in _SETTINGS.items():
            m.d.sync += getattr(self.settings, name).eq(attrgetter(path)(self.hardware))
        running = (control.run & self.loading.loaded) | self.calibrating
        m.d.comb += [
            self.tare.eq(control.tare),
            self.simulate.eq(control.simulate_error),
            self.taxel_forces.eq(control.taxel_forces),
            status.running.eq(register(m, running, "running", control=True)),
            status.loaded.eq(self.loading.loaded),
            status.busy.eq(self.busy),
            status.taring.eq(self.taring),
        ]
        self._calibration(m)
        self._load(m)
        self._errors(m)
        self._frames(m)
        return m

    def _calibration(self, m: Module) -> None:
        """CALIBRATION_...: words of the tables, whose place counts up with each, and their CRC."""
        m.submodules.crc = crc = Crc()
        place, word, tables = self.hardware.CALIBRATION_PLACE, self.hardware.CALIBRATION_DATA, self.tables
        chosen = place.index_written | place.kind_written
        index = Signal.like(place.index)
        with m.If(word.word_written):
            m.d.sync += index.eq(index + 1)
        with m.If(chosen):
            m.d.sync += index.eq(place.index)
        m.d.sync += [
            tables.index.eq(index),
            tables.kind.eq(place.kind),
            tables.data_written.eq(word.word_written),
        ]
        m.d.comb += [
            tables.data.eq(word.word),
            crc.restart.eq(chosen),
            crc.start.eq(word.word_written),
            crc.word.eq(word.word),
            self.hardware.CALIBRATION_VALUE.word.eq(tables.value),
            self.hardware.CALIBRATION_CRC.crc.eq(crc.crc),
        ]

    def _load(self, m: Module) -> None:
        """LOAD_...: coefficients of the core."""
        registers, loading = self.hardware, self.loading
        m.d.comb += [
            loading.word.eq(registers.LOAD_DATA.word),
            loading.written.eq(registers.LOAD_DATA.word_written),
            loading.checksum.eq(registers.LOAD_CHECKSUM.crc),
            registers.LOAD_COUNT.words_up.eq(loading.taken),
            registers.LOAD_CRC.crc.eq(loading.crc),
            registers.LOAD_STATUS.ready.eq(loading.ready),
            registers.LOAD_STATUS.match.eq(loading.match),
            registers.INTERRUPT_STATUS.loaded_set.eq(loading.done),
        ]

    def _errors(self, m: Module) -> None:
        """ERRORS, and its interrupt."""
        errors: dict[str, Value] = {
            **{name: getattr(self.events, name) for name in _EVENTS},
            "saturation": self.events.saturation | self.saturated,
            "stale": self._stale(m),
            "load_checksum": self.loading.wrong,
            "simulated": self.simulate,
        }
        m.d.comb += [getattr(self.hardware.ERRORS, f"{name}_set").eq(value) for name, value in errors.items()]
        m.d.comb += self.hardware.INTERRUPT_STATUS.error_set.eq(Cat(errors.values()).any())

    def _stale(self, m: Module) -> Value:
        """FRAME_TIMEOUT has passed since the last frame, or since the report of that."""
        timeout = self.hardware.FRAME_TIMEOUT.cycles
        passed = Signal(BITS)
        stale = Signal()
        counts = self.settings.run & self.loading.loaded & ~(self.events.accepted | self.events.dropped) & ~stale
        m.d.sync += [
            passed.eq(Mux(counts, passed + 1, 0)),
            stale.eq(counts & timeout.any() & (passed >= timeout)),
        ]
        return stale

    def _frames(self, m: Module) -> None:
        """FRAME...: counters and times, which software may hold; FAULTY_TAXEL."""
        registers, faulty, control = self.hardware, self.hardware.FAULTY_TAXEL, self.hardware.CONTROL
        ups = (self.events.accepted, self.ended, self.events.dropped, self.saturated)
        ports = (registers.FRAMES_IN, registers.FRAMES_OUT, registers.FRAMES_DROPPED, registers.FRAMES_SATURATED)
        for up, port in zip(ups, ports, strict=True):
            count = Signal(BITS, name="count")
            m.d.sync += count.eq(count + up)
            with m.If(control.clear_counters):
                m.d.sync += count.eq(up)
            m.d.comb += port.count.eq(count)
            m.d.comb += port.count_store.eq(~control.hold_counters)
        cycles = Signal(BITS)
        with m.If(self.ended):
            m.d.sync += cycles.eq(self.time - self.started)
        with m.Elif(control.clear_counters):
            m.d.sync += cycles.eq(0)
        m.d.comb += [
            registers.INTERRUPT_STATUS.frame_set.eq(self.ended),
            registers.FRAME_CYCLES.cycles.eq(cycles),
            registers.FRAME_CYCLES.cycles_store.eq(~control.hold_counters),
        ]
        for name, _ in FAULTY:
            m.d.comb += [
                getattr(faulty, name).eq(self.faulty[name]),
                getattr(faulty, f"{name}_store").eq(self.faulty_store),
            ]
