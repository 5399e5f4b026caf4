"""What the registers mean: settings, commands, events and counters of the blocks around the core."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.bank import hardware
from tfra.hdl.bus.map import BITS, RegisterMap
from tfra.hdl.front_end.ports import EVENTS, FAULTY, SETTINGS, TABLES
from tfra.hdl.ip.crc import Crc

LOADING = wiring.Signature(
    {
        **{"word": Out(BITS), "written": Out(1), "checksum": Out(BITS), "crc": In(BITS)},
        **dict.fromkeys(("ready", "taken", "match", "loaded", "done", "wrong"), In(1)),
    }
)
"""The way of software to the coefficients, as it drives it: see :class:`tfra.hdl.ip.load.Load`."""

_EVENTS = ("short_frame", "long_frame", "input_overflow", "sequence_gap", "out_of_range", "stuck")
"""Events of the front end that are errors of the same name."""


class Control(wiring.Component):
    """Between the ports of the registers and the blocks.

    Arguments: ``registers``: the map.

    Members:
        hardware: of the registers.
        settings, tables, loading: of software.
        restart: out, a soft reset, and the first cycle after the reset; a register.
        tare, simulate, taxel_forces: out, of CONTROL.
        time: out, counts cycles.
        events, faulty, faulty_store, taring: in, of the front end.
        saturated: in, a result that ends reports it.
        ended, started: in, the last word of an output frame is taken; the time of the frame's first taxel.
        busy: in, a frame is in the blocks or the core.
    """

    def __init__(self, registers: RegisterMap) -> None:
        super().__init__(
            {
                "hardware": In(hardware(registers)),
                "settings": Out(SETTINGS),
                "tables": Out(TABLES),
                "loading": Out(LOADING),
                "restart": Out(1, init=1),
                **dict.fromkeys(("tare", "simulate", "taxel_forces"), Out(1)),
                "time": Out(BITS),
                "events": In(EVENTS),
                "faulty": In(FAULTY),
                **dict.fromkeys(("faulty_store", "taring", "saturated", "ended", "busy"), In(1)),
                "started": In(BITS),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        control, status = self.hardware.CONTROL, self.hardware.STATUS
        m.d.sync += [self.restart.eq(control.soft_reset), self.time.eq(self.time + 1)]
        m.d.comb += [
            *(self.tare.eq(control.tare), self.simulate.eq(control.simulate_error)),
            *(self.taxel_forces.eq(control.taxel_forces), status.running.eq(control.run & self.loading.loaded)),
            *(status.loaded.eq(self.loading.loaded), status.busy.eq(self.busy), status.taring.eq(self.taring)),
        ]
        self._settings(m)
        self._calibration(m)
        self._load(m)
        self._errors(m)
        self._frames(m)
        return m

    def _settings(self, m: Module) -> None:
        hw, to = self.hardware, self.settings
        chosen = {
            **{name: getattr(hw.CONTROL, name) for name in ("run", "drop_late", "check_sequence")},
            **{name: getattr(hw.FRONT_END, name) for name in ("word_bits", "is_unsigned", "invert", "log2_average")},
            **{"log2_tare": hw.TARE.log2_frames, "stuck_frames": hw.STUCK.frames, "repair_words": hw.REPAIRS.words},
            **{name: getattr(hw.THRESHOLDS, name) for name in ("dead_band", "contact")},
        }
        m.d.comb += [getattr(to, name).eq(value) for name, value in chosen.items()]

    def _calibration(self, m: Module) -> None:
        m.submodules.crc = crc = Crc()
        place, word, to = self.hardware.CALIBRATION_PLACE, self.hardware.CALIBRATION_DATA, self.tables
        m.d.comb += [
            to.place_written.eq(place.index_written | place.kind_written),
            *(to.index.eq(place.index), to.kind.eq(place.kind), to.data.eq(word.word)),
            to.data_written.eq(word.word_written),
            *(crc.restart.eq(to.place_written), crc.start.eq(word.word_written), crc.word.eq(word.word)),
            self.hardware.CALIBRATION_VALUE.word.eq(to.value),
            self.hardware.CALIBRATION_CRC.crc.eq(crc.crc),
        ]

    def _load(self, m: Module) -> None:
        hw, to = self.hardware, self.loading
        m.d.comb += [
            *(to.word.eq(hw.LOAD_DATA.word), to.written.eq(hw.LOAD_DATA.word_written)),
            *(to.checksum.eq(hw.LOAD_CHECKSUM.crc), hw.LOAD_COUNT.words_up.eq(to.taken), hw.LOAD_CRC.crc.eq(to.crc)),
            *(hw.LOAD_STATUS.ready.eq(to.ready), hw.LOAD_STATUS.match.eq(to.match)),
            hw.INTERRUPT_STATUS.loaded_set.eq(to.done),
        ]

    def _errors(self, m: Module) -> None:
        found: dict[str, Value] = {name: getattr(self.events, name) for name in _EVENTS}
        found |= {"saturation": self.events.saturation | self.saturated, "stale": self._stale(m)}
        found |= {"load_checksum": self.loading.wrong, "simulated": self.simulate}
        m.d.comb += [getattr(self.hardware.ERRORS, f"{name}_set").eq(value) for name, value in found.items()]
        m.d.comb += self.hardware.INTERRUPT_STATUS.error_set.eq(Cat(found.values()).any())

    def _stale(self, m: Module) -> Value:
        """FRAME_TIMEOUT has passed since the last frame, or since the report of that."""
        hw = self.hardware
        passed, over = Signal(BITS), Signal()
        arrived = self.events.accepted | self.events.dropped
        counts = hw.STATUS.running & ~arrived & ~over
        m.d.sync += passed.eq(Mux(counts, passed + 1, 0))
        m.d.sync += over.eq(counts & hw.FRAME_TIMEOUT.cycles.any() & (passed >= hw.FRAME_TIMEOUT.cycles))
        return over

    def _frames(self, m: Module) -> None:
        hw, faulty = self.hardware, self.hardware.FAULTY_TAXEL
        m.d.comb += [
            *(hw.FRAMES_IN.count_up.eq(self.events.accepted), hw.FRAMES_DROPPED.count_up.eq(self.events.dropped)),
            *(hw.FRAMES_OUT.count_up.eq(self.ended), hw.FRAMES_SATURATED.count_up.eq(self.saturated)),
            hw.INTERRUPT_STATUS.frame_set.eq(self.ended),
            *(hw.FRAME_CYCLES.cycles.eq(self.time - self.started), hw.FRAME_CYCLES.cycles_store.eq(self.ended)),
            *(getattr(faulty, name).eq(self.faulty[name]) for name, _ in FAULTY),
            *(getattr(faulty, f"{name}_store").eq(self.faulty_store) for name, _ in FAULTY),
        ]
