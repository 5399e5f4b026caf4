"""Clock of each block of the core alone on a part, an upper limit of the whole core's.

``python -m bench.parts.blocks [BLOCK ...]`` places and routes the blocks of ``examples/fast.toml``, or those that are
named, one by one.  It updates their entries in ``bench/results/blocks.json``, and the table of docs/synth.md.
"""

from __future__ import annotations

import json
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

from amaranth.hdl import UnusedElaboratable
from amaranth.lib import wiring

from bench.parts.flat import Flat
from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import to_rtlil, with_free_collisions
from tfra.hdl.parallel.tfra.blocks import Blocks
from tfra.synth.flow import route, synthesise
from tfra.synth.pins import Pins
from tfra.synth.targets import find
from tfra.synth.tools import versions

TARGET = "ecp5-45-6"
AIM = 125.0
"""MHz, the target clock of the preset."""


def measure(name: str, block: wiring.Component) -> dict[str, Any]:
    """Resources and clock of one block between registers, for one seed."""
    target = find(TARGET)
    with tempfile.TemporaryDirectory() as folder:
        text = with_free_collisions(to_rtlil(Pins(Flat(block)), name))
        synthesise(text, name, target, Path(folder))
        found = route(target, Path(folder), 1, AIM)
    path = {"logic_ns": found.path.logic_ns, "routing_ns": found.path.routing_ns}
    return {"resources": dict(found.resources), "mhz": round(found.mhz, 1), **path, "tools": versions(target.family)}


def row(name: str, found: dict[str, Any]) -> str:
    """Markdown of one block."""
    used = " | ".join(f"{found['resources'][key]:,}" for key in ("LUT", "FF", "DSP", "BRAM"))
    return f"| `{name}` | {used} | {found['mhz']:.1f} | {found['logic_ns']:.1f} | {found['routing_ns']:.1f} |"


def main(names: list[str]) -> None:
    """Measure, store, publish."""
    warnings.simplefilter("ignore", UnusedElaboratable)  # one of all blocks at a time
    path = ROOT / "bench" / "results" / "blocks.json"
    record = json.loads(path.read_text()) if path.exists() else {}
    design = load(ROOT / "examples" / "fast.toml").design
    for name in names or [name for name, _ in Blocks.of(design)]:
        record[name] = measure(name, getattr(Blocks.of(design), name))
        print(name, record[name], flush=True)
    lines = [
        "| block | LUT | FF | DSP | BRAM | MHz alone | longest path: logic, ns | wires, ns |",
        "|---|" + "---:|" * 7,
        *(row(name, record[name]) for name in sorted(record, key=lambda name: float(record[name]["mhz"]))),
    ]
    publish("blocks", record, "\n".join(lines), "docs/synth.md")


if __name__ == "__main__":
    main(sys.argv[1:])
