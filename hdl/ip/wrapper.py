"""Everything around a core: streams of frames, front end, registers."""

from typing import Any

from amaranth import Module, ResetInserter, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.axi_lite import bus
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.bus.registers import Registers
from tfra.hdl.front_end.unit import PAGES, FrontEnd
from tfra.hdl.interface import ports
from tfra.hdl.interface.microarchitecture import Microarchitecture
from tfra.hdl.ip.control import Control
from tfra.hdl.ip.framer import HEADER_WORDS, Framer
from tfra.hdl.ip.load import Load
from tfra.hdl.ip.output_stage import OUTPUT_BEAT, OutputStage
from tfra.hdl.ip.width_converter import WidthConverter, input_beat
from tfra.hdl.skin.payloads import settings
from tfra.hdl.skin.timing import SkinTiming
from tfra.model.fixed.design import Design
from tfra.model.skin.records import record_words
from tfra.model.skin.skin import Skin, core_of


def latencies(core: Microarchitecture) -> tuple[int, int, int, int]:
    """Cycles from the transfer of a frame's last beat to those of its first and its last result word behind AXI.

    First the wrapper and ``core`` being idle, then the most when frames come back to back.  The whole frame passes to
    the core after its last beat, which comes after the frame ``PAGES`` before it has passed.  Headers delay frames that
    leave without a pause.
    """
    taxels = core.design.sensor.taxels
    converter = WidthConverter.latency(taxels, core.design.bus.taxels_per_beat)
    idle = converter + FrontEnd.latency + core.intake + OutputStage.latency
    queued = converter - taxels + HEADER_WORDS + OutputStage.latency
    first, last = core.queued(PAGES)
    queued += (interval(core) - core.initiation_interval) * -(-last // core.initiation_interval)
    return core.latency + idle, core.frame_latency + idle, first + queued, last + queued


def cut_through(core: Microarchitecture) -> tuple[int, int]:
    """The first two of :func:`latencies` if frames are cut through, their taxels coming without a pause."""
    first, last, *_ = latencies(core)
    earlier = FrontEnd.latency - FrontEnd.cut_through + core.design.sensor.taxels - 1
    return first - earlier, last - earlier


def interval(core: Microarchitecture) -> int:
    """Cycles from one frame to the next behind AXI when frames come back to back, on average."""
    return max(core.initiation_interval, HEADER_WORDS + core.design.frame_words)


def skin_latencies(timing: SkinTiming) -> tuple[int, int]:
    """As the first two of :func:`latencies`, the most of a skin that is idle."""
    taxels, per_beat = timing.skin.sensor.taxels, timing.core.design.bus.taxels_per_beat
    around = WidthConverter.latency(taxels, per_beat) + FrontEnd.latency + taxels - 1 + OutputStage.latency
    return around + timing.latency, around + timing.frame_latency


def skin_interval(timing: SkinTiming) -> int:
    """As :func:`interval`, the most of a skin."""
    return max(timing.interval, HEADER_WORDS + timing.skin.choices.most * record_words(timing.skin))


class Wrapper(wiring.Component):
    """Frames of the converters in, output frames out, and registers that control both; the core is beside it.

    ::

        frames ─▶ width converter ─▶ front end ─▶ taxel ─▶ (core) ─▶ result ─▶ framer ─▶ output stage ─▶ results
                                        └───────── facts of the frame ───────────▲
        axi ─▶ registers ─▶ control ─▶ settings, tables, load

    ``loaded`` says whether the core has coefficients to be loaded.  Raises ``ValueError`` for converters and result
    words that don't fit.
    """

    def __init__(self, array: Design | Skin, registers: RegisterMap, *, loaded: bool) -> None:
        design = core_of(array)
        per_beat, coefficient = design.bus.taxels_per_beat, signed(design.coefficient_word)
        self._registers, self._control = Registers(registers), Control(registers)
        self._converter = WidthConverter(array.sensor.taxels, per_beat)
        self._front_end, self._framer, self._output = FrontEnd(array), Framer(array), OutputStage()
        self._load = Load(design.coefficient_word) if loaded else None
        super().__init__({
            "axi": In(bus(registers.address_bits)),  # AXI4-Lite of the registers
            "frames": In(stream.Signature(input_beat(per_beat))),
            "results": Out(stream.Signature(OUTPUT_BEAT)),
            "interrupt": Out(1),  # a level
            "core_reset": Out(1),  # a register
            "taxel": Out(stream.Signature(ports.taxel(design))),  # to the core
            "result": In(stream.Signature(ports.result(array))),  # of the core
            **({"load": Out(stream.Signature(coefficient))} if loaded else {}),  # to a core that is loaded
            **({"contacts": Out(settings(array.choices))} if isinstance(array, Skin) else {}),  # to that of a skin
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        restart = self._control.restart
        m.submodules.registers = self._registers
        m.submodules.control = self._control
        m.submodules.converter = self._converter
        m.submodules.front_end = ResetInserter(restart)(self._front_end)
        m.submodules.framer = ResetInserter(restart)(self._framer)
        m.submodules.output = self._output
        self._connect_frames(m)
        self._connect_registers(m)
        self._connect_load(m)
        m.d.comb += [
            self.core_reset.eq(restart),
            self._converter.restart.eq(restart),
            self._output.restart.eq(restart),
            self._front_end.skip.eq(self._converter.cut),
        ]
        return m

    def _connect_frames(self, m: Module) -> None:
        """The way of a frame to the core and back."""
        connect(m, flipped(self.frames), self._converter.i)
        connect(m, self._converter.o, self._front_end.i)
        connect(m, self._front_end.codes, flipped(self.taxel))
        connect(m, self._front_end.facts, self._framer.facts)
        connect(m, flipped(self.result), self._framer.result)
        connect(m, self._framer.o, self._output.i)
        connect(m, self._output.o, flipped(self.results))

    def _connect_registers(self, m: Module) -> None:
        """Commands and settings to the blocks, their events and states back."""
        control, front_end = self._control, self._front_end
        connect(m, flipped(self.axi), self._registers.bus)
        connect(m, self._registers.hardware, control.hardware)
        connect(m, control.settings, front_end.settings)
        connect(m, control.tables, front_end.tables)
        connect(m, control.events, front_end.events)
        if "contacts" in self.signature.members:
            connect(m, self._registers.hardware.CONTACTS, flipped(self.contacts))
        m.d.comb += [
            self.interrupt.eq(self._registers.interrupt),
            front_end.tare.eq(control.tare),
            front_end.simulate.eq(control.simulate),
            front_end.time.eq(control.time),
            self._framer.taxel_forces.eq(control.taxel_forces),
            control.faulty.eq(front_end.faulty),
            control.faulty_store.eq(front_end.faulty_store),
            control.taring.eq(front_end.taring),
            control.saturated.eq(self._framer.saturated),
            control.ended.eq(self._output.ended),
            control.started.eq(self._output.started),
            control.calibrating.eq(front_end.busy),
            control.busy.eq(front_end.busy | self._framer.busy | self._output.busy),
        ]

    def _connect_load(self, m: Module) -> None:
        """The words of software to the core, or the state of a core that needs none."""
        loading = self._control.loading
        if self._load is None:
            m.d.comb += loading.loaded.eq(1)
            m.d.comb += loading.match.eq(~loading.checksum.any())
            return
        m.submodules.load = ResetInserter(self._control.restart)(self._load)
        connect(m, loading, self._load.software)
        connect(m, self._load.o, flipped(self.load))
