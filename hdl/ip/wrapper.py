"""Everything around a core: streams of frames, front end, registers."""

from __future__ import annotations

from typing import Any

from amaranth import Module, ResetInserter, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.bus.axi_lite import bus
from tfra.hdl.bus.map import RegisterMap
from tfra.hdl.bus.registers import Registers
from tfra.hdl.front_end.unit import FrontEnd
from tfra.hdl.interface import ports
from tfra.hdl.ip.control import Control
from tfra.hdl.ip.framer import Framer
from tfra.hdl.ip.load import Load
from tfra.hdl.ip.ports import OUTPUT, beat
from tfra.hdl.ip.tail import Tail
from tfra.hdl.ip.unpack import Unpack
from tfra.model.fixed.design import Design


class Wrapper(wiring.Component):
    """Frames of the converters in, output frames out, and registers that control both; the core is beside it.

    ::

        frames ─▶ unpack ─▶ front end ─▶ taxel ─▶ (core) ─▶ result ─▶ framer ─▶ tail ─▶ results
                              └───────── facts of the frame ──────────▲
        axi ─▶ registers ─▶ control ─▶ settings, tables, load

    Raises ``ValueError`` for converters and result words that don't fit.

    Arguments: ``design``; ``registers``: its map; ``loaded``: whether the core's coefficients are loaded.

    Members:
        axi: AXI4-Lite of the registers.
        frames: stream in, beats of taxels.
        results: stream out, output frames.
        interrupt: out, a level.
        core_reset: out, resets the core; a register.
        taxel, result, load: streams of the core, ``load`` only of one that is loaded.
    """

    def __init__(self, design: Design, registers: RegisterMap, *, loaded: bool) -> None:
        self._map, self._loaded = registers, loaded
        self._taxels = design.sensor.taxels
        self._unpack = Unpack(self._taxels, design.bus.taxels_per_beat)
        self._front_end, self._framer = FrontEnd(design), Framer(design)
        self._coefficient = design.coefficient_word
        super().__init__(
            {
                "axi": In(bus(registers.address_bits)),
                "frames": In(stream.Signature(beat(design.bus.taxels_per_beat))),
                "results": Out(stream.Signature(OUTPUT)),
                "interrupt": Out(1),
                "core_reset": Out(1),
                "taxel": Out(stream.Signature(ports.taxel(design))),
                "result": In(stream.Signature(ports.result(design))),
                **({"load": Out(stream.Signature(signed(design.coefficient_word)))} if loaded else {}),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a frame's last beat to that of its first result word, less those of the core.

        The whole frame passes to the core after its last taxel.
        """
        return self._unpack.latency + self._front_end.latency + self._taxels - 1 + Tail.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.registers = registers = Registers(self._map)
        m.submodules.control = control = Control(self._map)
        m.submodules.unpack = unpack = self._unpack
        m.submodules.front_end = ResetInserter(control.restart)(self._front_end)
        m.submodules.framer = ResetInserter(control.restart)(self._framer)
        m.submodules.tail = tail = Tail()
        front_end, framer = self._front_end, self._framer
        connect(m, flipped(self.axi), registers.bus)
        connect(m, registers.hardware, control.hardware)
        connect(m, flipped(self.frames), unpack.i)
        connect(m, unpack.o, front_end.i)
        connect(m, front_end.codes, flipped(self.taxel))
        connect(m, front_end.facts, framer.facts)
        connect(m, flipped(self.result), framer.result)
        connect(m, framer.o, tail.i)
        connect(m, tail.o, flipped(self.results))
        for name in ("settings", "tables", "events"):
            connect(m, getattr(control, name), getattr(front_end, name))
        m.d.comb += [
            *(self.interrupt.eq(registers.interrupt), self.core_reset.eq(control.restart)),
            *(unpack.restart.eq(control.restart), tail.restart.eq(control.restart), front_end.skip.eq(unpack.cut)),
            *(getattr(front_end, name).eq(getattr(control, name)) for name in ("tare", "simulate", "time")),
            *(getattr(control, name).eq(getattr(front_end, name)) for name in ("faulty", "faulty_store", "taring")),
            *(framer.taxel_forces.eq(control.taxel_forces), control.saturated.eq(framer.saturated)),
            *(control.ended.eq(tail.ended), control.started.eq(tail.started)),
            control.busy.eq(front_end.busy | framer.busy | tail.busy),
        ]
        self._load(m, control)
        return m

    def _load(self, m: Module, control: Control) -> None:
        """The words of software to the core, or the state of a core that needs none."""
        to = control.loading
        if not self._loaded:
            m.d.comb += [to.loaded.eq(1), to.match.eq(~to.checksum.any())]
            return
        load = Load(self._coefficient)
        m.submodules.load = ResetInserter(control.restart)(load)
        connect(m, load.o, flipped(self.load))
        m.d.comb += [
            to.ready.eq(load.o.ready),
            *(getattr(load, name).eq(getattr(to, name)) for name in ("word", "written", "checksum")),
            *(getattr(to, name).eq(getattr(load, name)) for name in ("taken", "crc", "match", "loaded", "done")),
            to.wrong.eq(load.wrong),
        ]
