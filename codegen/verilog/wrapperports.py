"""Ports of the wrapper NAME_axi; names are those of AMBA."""

from typing import Literal

from tfra.codegen.sidecar.schema import Port
from tfra.hdl.bus.map import BITS, BYTES
from tfra.hdl.front_end.ports import NUMBER
from tfra.model.fixed.design import Design
from tfra.model.fixed.front_end import WORD

_Way = Literal["in", "out"]
_Word = tuple[str, int, str]

_LAST = ("last", 1, "last beat of a frame")
_CUT = ("user", 1, "1, with tlast: a soft reset ended this frame: throw it away")


def input_bits(design: Design) -> int:
    """Bits of a beat of taxels."""
    return WORD * design.bus.taxels_per_beat


def wrapper_ports(design: Design, address_bits: int) -> list[Port]:
    """All ports in order; registers have addresses of ``address_bits``."""
    slots = design.bus.taxels_per_beat
    beat = f"{slots} taxels, {WORD} bits each, the first one lowest" if slots > 1 else "a taxel"
    address = [("addr", address_bits, "address, in bytes"), ("prot", 3, "ignored")]
    answer, number = ("resp", 2, "0 OKAY, 2 SLVERR"), ("user", NUMBER, "frame number, with tlast")
    return [
        Port(name="aclk", direction="in", bits=1, note="clock, rising edge"),
        Port(name="aresetn", direction="in", bits=1, note="synchronous reset, active low"),
        *_channel("s_axi_aw", "in", address),
        *_channel("s_axi_w", "in", [("data", BITS, "word to write"), ("strb", BYTES, "which of its bytes")]),
        *_channel("s_axi_b", "out", [answer]),
        *_channel("s_axi_ar", "in", address),
        *_channel("s_axi_r", "out", [("data", BITS, "word read"), answer]),
        *_channel("s_axis_t", "in", [("data", input_bits(design), beat), number, _LAST]),
        *_channel("m_axis_t", "out", [("data", BITS, "a beat of the output frame"), _CUT, _LAST]),
        Port(name="irq", direction="out", bits=1, note="high while an enabled bit of INTERRUPT_STATUS is 1"),
    ]


def _channel(prefix: str, way: _Way, words: list[_Word]) -> list[Port]:
    back: _Way = "in" if way == "out" else "out"
    rows: list[tuple[str, _Way, int, str]] = [(name, way, bits, note) for name, bits, note in words]
    rows += [("valid", way, 1, "the channel has a transfer"), ("ready", back, 1, "it is taken")]
    return [Port(name=f"{prefix}{name}", direction=flow, bits=bits, note=note) for name, flow, bits, note in rows]
