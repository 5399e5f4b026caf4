"""Ports of the wrapper NAME_axi."""

from __future__ import annotations

from dataclasses import dataclass

from tfra.codegen.registers.values import parameters
from tfra.model.fixed.design import Design

WORD = 16
"""Bits of a taxel's slot in a beat."""


@dataclass(frozen=True)
class Pin:
    """A port of ``bits``, an ``in`` or an ``out``."""

    name: str
    direction: str
    bits: int
    note: str


def input_bits(design: Design) -> int:
    """Bits of a beat of taxels."""
    return WORD * parameters(design)["TAXELS_PER_BEAT"]


def pins(design: Design) -> list[Pin]:
    """All ports in order; names are those of AMBA."""
    beat = input_bits(design)
    slots = f"{beat // WORD} taxels, 16 bits each, the first one lowest" if beat > WORD else "a taxel"
    rows = [
        ("aclk", "in", 1, "clock, rising edge"),
        ("aresetn", "in", 1, "synchronous reset, active low"),
        *_channel("s_axi_aw", "in", [("addr", 8, "write address, in bytes"), ("prot", 3, "ignored")]),
        *_channel("s_axi_w", "in", [("data", 32, "word to write"), ("strb", 4, "which of its bytes")]),
        *_channel("s_axi_b", "out", [("resp", 2, "0 OKAY, 2 SLVERR")]),
        *_channel("s_axi_ar", "in", [("addr", 8, "read address, in bytes"), ("prot", 3, "ignored")]),
        *_channel("s_axi_r", "out", [("data", 32, "word read"), ("resp", 2, "0 OKAY, 2 SLVERR")]),
        *_channel("s_axis_t", "in", [("data", beat, slots), ("user", 16, "frame number, read with tlast"), _LAST]),
        *_channel("m_axis_t", "out", [("data", 32, "a beat of the output frame"), _RESET, _LAST]),
        ("interrupt", "out", 1, "high while an enabled bit of INTERRUPT_STATUS is 1"),
    ]
    return [Pin(*row) for row in rows]


_LAST = ("last", 1, "last beat of a frame")
_RESET = ("user", 1, "1: a soft reset ended this frame: throw it away")


def _channel(prefix: str, direction: str, words: list[tuple[str, int, str]]) -> list[tuple[str, str, int, str]]:
    back = "in" if direction == "out" else "out"
    return [
        *((f"{prefix}{name}", direction, bits, note) for name, bits, note in words),
        (f"{prefix}valid", direction, 1, ""),
        (f"{prefix}ready", back, 1, ""),
    ]
