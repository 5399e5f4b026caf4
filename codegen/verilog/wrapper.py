"""Verilog of the core behind buses: ``NAME_axi``, with registers on AXI4-Lite and frames on AXI4-Stream."""

from collections.abc import Iterator, Sequence
from typing import Any, Literal

from amaranth import ClockDomain, Module
from amaranth.lib import wiring

from tfra.codegen.registers.source import registers_of
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog.emit import FLOWS, connect_ports, core_instance, plain_verilog, to_rtlil
from tfra.codegen.verilog.header import head, wrapped
from tfra.hdl.bus.map import BITS, BYTES
from tfra.hdl.cores import microarchitecture
from tfra.hdl.front_end.ports import NUMBER
from tfra.hdl.ip import framer
from tfra.hdl.ip.framer import FAULTS, FORMAT_PLACE, HEADER_WORDS, forces, version
from tfra.hdl.ip.wrapper import Wrapper
from tfra.hdl.primitives import cell_models
from tfra.model.fixed import front_end
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import WORD
from tfra.model.skin.records import record_words
from tfra.model.skin.skin import Skin, core_of

RULES = {
    "clock": "every port belongs to aclk and counts at its rising edge",
    "reset": (
        "aresetn is synchronous, active low, and needed for one cycle at least after power-up. The register"
        " CONTROL.soft_reset resets core and streams, but no register; it skips the rest of a frame that it cuts at the"
        " input, and ends one that it cuts at the output by a beat with tlast and tuser high, whose bits are ones"
    ),
    "start": "no frame is taken until CONTROL.run is 1; a loaded core needs its coefficients by LOAD_DATA before",
    "streams": (
        "a beat moves at a rising edge with valid and ready high; no output depends on an input of the same cycle"
    ),
    "short and long frames": (
        "are dropped whole, counted in FRAMES_DROPPED and reported in ERRORS; the next frame is not affected"
    ),
}
"""Rules of the ports, as sentences."""

_Way = Literal["in", "out"]


def check_wrapped(array: Design | Skin) -> None:
    """Raise ``ValueError`` that names a section of CONFIG where converter or result words do not fit the wrapper."""
    front_end.check(array)
    framer.check(array)


def wrapper(array: Design | Skin) -> Wrapper:
    """Everything around the core of a design or a skin; raises ``ValueError`` for a converter that does not fit.

    Raises ``InputError`` without the compiler of the register map.
    """
    return Wrapper(array, registers_of(array), loaded=microarchitecture(core_of(array)).loaded is not None)


def module_name(array: Design | Skin) -> str:
    """Name of the wrapper's module."""
    return f"{array.name}_axi"


def slots_of(array: Design | Skin) -> int:
    """Taxels in a beat."""
    return core_of(array).bus.taxels_per_beat


def input_bits(array: Design | Skin) -> int:
    """Bits of a beat of taxels."""
    return WORD * slots_of(array)


def ports_of(array: Design | Skin) -> list[Port]:
    """Ports of the module in order; names are those of AMBA."""
    slots = slots_of(array)
    beat = f"{slots} taxels, {WORD} bits each, the first one lowest" if slots > 1 else "a taxel"
    address = [("addr", registers_of(array).address_bits, "address, in bytes"), ("prot", 3, "ignored")]
    answer, number = ("resp", 2, "0 OKAY, 2 SLVERR"), ("user", NUMBER, "frame number, with tlast")
    last = ("last", 1, "last beat of a frame")
    cut = ("user", 1, "1, with tlast: a soft reset ended this frame: throw it away")
    return [
        Port(name="aclk", direction="in", bits=1, note="clock, rising edge"),
        Port(name="aresetn", direction="in", bits=1, note="synchronous reset, active low"),
        *_channel("s_axi_aw", "in", address),
        *_channel("s_axi_w", "in", [("data", BITS, "word to write"), ("strb", BYTES, "which of its bytes")]),
        *_channel("s_axi_b", "out", [answer]),
        *_channel("s_axi_ar", "in", address),
        *_channel("s_axi_r", "out", [("data", BITS, "word read"), answer]),
        *_channel("s_axis_t", "in", [("data", input_bits(array), beat), number, last]),
        *_channel("m_axis_t", "out", [("data", BITS, "a beat of the output frame"), cut, last]),
        Port(name="irq", direction="out", bits=1, note="high while an enabled bit of INTERRUPT_STATUS is 1"),
    ]


def _channel(prefix: str, way: _Way, words: list[tuple[str, int, str]]) -> list[Port]:
    """Ports of a stream that goes ``way``: its ``words`` (name, bits, note), and the handshake."""
    back: _Way = "in" if way == "out" else "out"
    forward = [*words, ("valid", 1, "the channel has a transfer")]
    ports = [Port(name=prefix + name, direction=way, bits=bits, note=note) for name, bits, note in forward]
    return [*ports, Port(name=f"{prefix}ready", direction=back, bits=1, note="it is taken")]


class Top(wiring.Component):
    """The wrapper under the standard's port names, and the core as a module from elsewhere."""

    def __init__(self, array: Design | Skin) -> None:
        self._array, self._wrapper = array, wrapper(array)
        self.ports = ports_of(array)
        super().__init__({port.name: FLOWS[port.direction](port.bits) for port in self.ports})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.domains.sync = sync = ClockDomain()
        m.submodules.core = inner = self._wrapper
        m.d.comb += sync.clk.eq(self.aclk)
        m.d.comb += sync.rst.eq(~self.aresetn)
        connect_ports(m, self, _signals(inner))
        m.submodules.instance = core_instance(self._array, inner, inner.core_reset)
        return m


def _signals(inner: Wrapper) -> dict[str, Any]:
    """Signals of the wrapper by the names of their ports."""
    frames, results = inner.frames, inner.results
    return {
        **{f"s_axi_{name}": getattr(inner.axi, name) for name in inner.axi.signature.members},
        "s_axis_tdata": frames.p.words.as_value(),
        "s_axis_tuser": frames.p.user,
        "s_axis_tlast": frames.p.last,
        "s_axis_tvalid": frames.valid,
        "s_axis_tready": frames.ready,
        "m_axis_tdata": results.p.data,
        "m_axis_tuser": results.p.user,
        "m_axis_tlast": results.p.last,
        "m_axis_tvalid": results.valid,
        "m_axis_tready": results.ready,
        "irq": inner.interrupt,
    }


def wrapper_verilog(array: Design | Skin) -> str:
    """Verilog of the module ``NAME_axi``, which has one instance of the core's, ``NAME``; the same text always.

    Raises ``ValueError`` for a converter of fewer than 8 or more than 16 bits or a result word beyond 32,
    ``InputError`` without the compiler of the register map, ``ToolError`` when yosys fails.
    """
    name, top = module_name(array), Top(array)
    order = [port.name for port in top.ports]
    cells = (file.read_text() for file in cell_models(core_of(array).target, "multiplier"))
    return header(array, top.ports) + plain_verilog(to_rtlil(top, name), name, order, cells)


def header(array: Design | Skin, ports: Sequence[Port]) -> str:
    """Comment at the head: ``ports``, rules, frames, and where the registers are described."""
    facts, sensor, beat = sidecar(array), array.sensor, slots_of(array)
    size, beats = f"{sensor.rows} x {sensor.columns} taxels", -(-sensor.taxels // beat)
    text = f"Module {module_name(array)} has one instance of {array.name}, which is in {array.name}.v."
    sections = {
        "Frames in": [
            f"{size}, row by row, in {beats} beats of {beat}; TLAST with the last beat",
            f"a word has {array.adc.bits} bits after a reset, two's complement, in the low bits of its {WORD}",
            "a frame of another length is dropped and counted",
        ],
        "Frames out": _frames_out(array),
        "Registers": ["those of registers/tfra.h, from address 0 on; CONTROL.run = 1 starts the core"],
    }
    return head(facts, " behind AXI", text, [port.model_dump() for port in ports], RULES, sections)


def _frames_out(array: Design | Skin) -> Iterator[str]:
    flags = ", ".join(f"{place} {name}" for name, place in FAULTS.items())
    yield "word 0: bits 15:0 sequence, which counts frames that came, good or bad; bits 31:16 TUSER of the frame"
    yield from wrapped(f"word 1: faults of the frame, bits {flags}; bits 31:{FORMAT_PLACE} format, {version(array)}", 2)
    if isinstance(array, Skin):
        words = f"records of {record_words(array)} words of {array.name}.v"
        yield f"words from {HEADER_WORDS} on: {words}, one for each contact,"
        yield f"  their signs extended to {BITS} bits; TLAST with the last word of the last record"
    else:
        first, last = HEADER_WORDS, HEADER_WORDS + array.frame_words - 1
        words = f"words {first}..{last}: those of {array.name}.v"
        yield f"{words}, their signs extended to {BITS} bits; TLAST with the last"
    if forces(array):
        yield "CONTROL.taxel_forces = 0 leaves the forces at the taxels out"
    yield "TUSER = 1 with TLAST, and all bits 1: a soft reset cut this frame; throw it away"
