"""What the front end takes on parts.

``python -m bench.parts.front_end_size`` synthesises that of ``examples/fast.toml``, and writes
``bench/results/front_end_size.json`` and the table of docs/front_end.md.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.verilog.emit import to_rtlil, with_free_collisions
from tfra.hdl.front_end.unit import FrontEnd
from tfra.model.fixed.design import Design
from tfra.synth.flow import synthesise
from tfra.synth.targets import find

PAGE = "docs/front_end.md"
TARGETS = {"ecp5-25-6": "ecp5", "ice40up5k": "ice40", "xc7": "portable"}
"""Family of each part, as in CONFIG's `[target]`."""
USED = ("LUT", "FF", "DSP", "BRAM")


def measure(design: Design, part: str) -> dict[str, int]:
    """Resources on ``part``, from yosys."""
    unit = FrontEnd(design.built_as(design.architecture, target=TARGETS[part]))
    with tempfile.TemporaryDirectory() as folder:
        text = with_free_collisions(to_rtlil(unit, "front_end"))
        found = synthesise(text, "front_end", find(part), Path(folder))
    return {name: found.resources[name] for name in USED}


def main() -> None:
    """Measure, store, publish."""
    design = load(ROOT / "examples" / "fast.toml").design
    record: dict[str, Any] = {part: measure(design, part) for part in TARGETS}
    lines = [f"| part | {' | '.join(USED)} |", "|---|" + "---:|" * len(USED)]
    lines += [f"| `{part}` | {' | '.join(f'{record[part][name]:,}' for name in USED)} |" for part in TARGETS]
    publish("front_end_size", record, "\n".join(lines), PAGE)


if __name__ == "__main__":
    main()
