"""How often registers change: toggles of each register bit a cycle, counted in simulations of the presets.

``python -m bench.parts.toggles`` simulates contacts, frame after frame, reads the waves, and writes the table of
docs/synth.md.  ``tfra.synth.power`` has the means of each kind of core.
"""

import re
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.cover.scenes import known_contacts
from tfra.model.fixed.design import Design
from tfra.runtime.store import cache_directory
from tfra.sim.run import generated, simulate

PRESETS = ("balanced", "small", "learned_resultant", "learned_small")
FRAMES = 2


def registers(verilog: str) -> tuple[dict[str, set[str]], dict[tuple[str, str], str]]:
    """By module the names that its clocked blocks assign; by module and instance, the module that this is one of."""
    assigned: dict[str, set[str]] = defaultdict(set)
    made_of: dict[tuple[str, str], str] = {}
    module = ""
    for line in verilog.splitlines():
        if found := re.match(r"module \\?(\S+?)\s*\(", line):
            module = found[1]
        elif found := re.match(r"\s+\\?(\S+)\s+<= ", line):
            assigned[module].add(found[1])
        elif found := re.match(r"\s+\\?([\w.$]+)\s+\\?([\w.$]+)\s*\($", line):
            made_of[module, found[2]] = found[1]
    return assigned, made_of


def count(waves: Iterator[str], verilog: str, top: str) -> tuple[int, int]:
    """Bits of all registers of module ``top`` in the lines of a VCD file, and how often they change."""
    assigned, made_of = registers(verilog)
    place: list[str] = []
    widths: dict[str, int] = {}
    last: dict[str, int] = {}
    changes = 0
    for line in map(str.strip, waves):
        if line.startswith("b"):
            value, code = line[1:].split()
        elif line.startswith(("0", "1", "x", "z")):
            value, code = line[0], line[1:]
        elif line.startswith("$scope"):
            name = line.split()[2]
            inner = made_of.get((place[-1], name), "") if place else ""
            place.append(inner or (top if name == top else ""))
            continue
        elif line.startswith("$upscope"):
            place.pop()
            continue
        elif line.startswith("$var"):
            _, _, width, code, name, *_ = line.split()
            if place[-1] and name.lstrip("\\") in assigned[place[-1]]:
                widths[code] = int(width)
            continue
        else:
            continue
        if code in widths and "x" not in value:
            number = int(value.replace("z", "0"), 2)
            changes += (number ^ last.get(code, number)).bit_count()
            last[code] = number
    return sum(widths.values()), changes


def toggles(design: Design) -> dict[str, Any]:
    """Register bits, cycles and toggles of a core, of contacts that follow each other without a pause."""
    codes = known_contacts(design, FRAMES, 0).codes
    with tempfile.TemporaryDirectory() as folder:
        waves = Path(folder) / "waves.vcd"
        run = simulate(design, codes, waves=waves)
        core = generated(design, cache_directory(None))
        with waves.open() as lines:
            bits, changes = count(lines, core.verilog, core.top)
    rate = changes / (bits * run.cycles)
    return {"name": design.name, "kind": design.architecture.kind, "bits": bits, "cycles": run.cycles, "rate": rate}


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: a row for each preset."""
    lines = ["| core | register bits | cycles | toggles of a bit a cycle |", "|---|---:|---:|---:|"]
    lines += [f"| `{row['name']}` | {row['bits']:,} | {row['cycles']:,} | {row['rate']:.3f} |" for row in rows]
    return "\n".join(lines)


def main() -> None:
    """Simulate, count, publish."""
    rows = []
    for preset in PRESETS:
        rows.append(toggles(load(ROOT / "examples" / f"{preset}.toml").design))
        print(rows[-1], flush=True)
    publish("toggles", {"rows": rows}, table(rows), "docs/synth.md")


if __name__ == "__main__":
    main()
