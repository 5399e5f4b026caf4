"""Pictures of the datasheet: the blocks, and the signals over time, as SVG."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

_BOXES = (
    ("unpack", 150, "beats to taxels"),
    ("front end", 300, "taxels to codes"),
    ("core", 450, "codes to words"),
    ("framer", 600, "words to beats"),
)
"""Name, place and purpose of the blocks that frames pass."""


def blocks(name: str) -> str:
    """The wrapper of the core ``name``: streams above, registers below."""
    parts = [_text(75, 47, "s_axis", "port"), _arrow(30, 60, 150, 60), _arrow(705, 60, 800, 60)]
    parts += [_text(757, 47, "m_axis", "port")]
    for title, x, purpose in _BOXES:
        parts += [_box(x, 30, 105, 60, title), _text(x + 52, 76, purpose, "small")]
        parts += [_arrow(x + 105, 60, x + 150, 60)] if x < 600 else []
    parts += [_box(150, 130, 555, 46, "registers: settings, tables, coefficients, control, counters, interrupt")]
    parts += [_arrow(x + 52, 130, x + 52, 90) for _, x, _ in _BOXES]
    parts += [_text(75, 141, "s_axi", "port"), _arrow(30, 154, 150, 154)]
    parts += [_text(757, 141, "irq", "port"), _arrow(705, 154, 800, 154)]
    label = f'role="img" aria-label="Blocks of {escape(name)}_axi"'
    return f'<svg class="blocks" viewBox="0 0 830 190" {label}>{"".join(parts)}</svg>'


def _box(x: int, y: int, width: int, height: int, title: str) -> str:
    middle = y + (height / 2 + 5 if height < 50 else 26)
    rectangle = f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="4"/>'
    return rectangle + _text(x + width // 2, middle, title, "title")


def _text(x: float, y: float, words: str, kind: str) -> str:
    return f'<text x="{x}" y="{y}" class="{kind}">{escape(words)}</text>'


def _arrow(x1: int, y1: int, x2: int, y2: int) -> str:
    right, down = (x2 > x1) - (x2 < x1), (y2 > y1) - (y2 < y1)
    back_x, back_y = x2 - 7 * right, y2 - 7 * down
    head = f"{x2},{y2} {back_x + 4 * down},{back_y + 4 * right} {back_x - 4 * down},{back_y - 4 * right}"
    return f'<line x1="{x1}" y1="{y1}" x2="{back_x}" y2="{back_y}"/><polygon points="{head}"/>'


def _wave(name: str, wave: str, *data: str) -> dict[str, Any]:
    return {"name": name, "wave": wave, **({"data": list(data)} if data else {})}


def waves() -> dict[str, str]:
    """Diagrams by their names: input, output, write of a register, reset."""
    clock = _wave("aclk", "p.........")
    made = {
        "input": [
            *(clock, _wave("s_axis_tvalid", "01..01.0.."), _wave("s_axis_tready", "1.01......")),
            _wave("s_axis_tdata", "x34.x35x..", "first", "…", "…", "last"),
            *(_wave("s_axis_tlast", "x0..x01x.."), _wave("s_axis_tuser", "x.....5x..", "number")),
        ],
        "output": [
            *(clock, _wave("m_axis_tvalid", "01......0."), _wave("m_axis_tready", "1...01....")),
            _wave("m_axis_tdata", "x3456..7x.", "beat 0", "beat 1", "word 0", "…", "status"),
            *(_wave("m_axis_tlast", "x0.....1x."), _wave("m_axis_tuser", "x0......x.")),
        ],
        "write": [
            *(clock, _wave("s_axi_awvalid", "01.0......"), _wave("s_axi_awready", "0.10......")),
            *(_wave("s_axi_awaddr", "x3.x......", "address"), _wave("s_axi_wvalid", "01.0......")),
            *(_wave("s_axi_wready", "0.10......"), _wave("s_axi_wdata", "x4.x......", "word")),
            *(_wave("s_axi_wstrb", "x4.x......", "1111"), _wave("s_axi_bvalid", "0....1.0..")),
            *(_wave("s_axi_bready", "0.....10.."), _wave("s_axi_bresp", "x....5.x..", "OKAY")),
        ],
        "reset": [
            *(clock, _wave("aresetn", "10...1....")),
            _wave("inputs …valid", "x0.......1"),
        ],
    }
    return {name: drawn(signals) for name, signals in made.items()}


def drawn(signals: Sequence[Mapping[str, Any]]) -> str:
    """A timing diagram of WaveDrom's ``signals``, to be put into a page."""
    import wavedrom

    svg = wavedrom.render(json.dumps({"signal": signals, "config": {"hscale": 2}})).tostring()
    return str(svg[svg.index("<svg") :])
