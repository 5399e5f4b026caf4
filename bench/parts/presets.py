"""The presets on their parts: the table of what ``tfra synth`` has reported, which datasheets read, too.

``python -m bench.parts.presets DIRECTORY ...`` reads the ``report.json`` of every directory that ``tfra synth PRESET
--out`` wrote, with ``--package`` or without, stores what is needed of it in ``codegen/package/measured.json``, and
writes the table in docs/measured.md.  It measures nothing itself: place and route takes minutes to hours.  Of Verilog
that is not that of the presets any more, nothing is kept.
"""

import json
import sys
from functools import cache
from pathlib import Path
from typing import Any

from bench.parts.axi_cost import PRESETS
from bench.publish import ROOT, insert
from tfra.codegen.config.read import load
from tfra.codegen.verilog.files import fingerprint, modules
from tfra.model.fixed.design import Design
from tfra.synth.page import fmax
from tfra.synth.run import SIDECAR

PUBLISHED_MS = (58.68, 32.28)
"""Time of a frame on SpTFRA's FPGA (doi:10.3390/s24237829), and the longest of TFRA in Matlab."""
MEASURED = ROOT / "codegen" / "package" / "measured.json"
KEYS = (
    *("name", "package", "netlist", "target", "architecture", "mac_lanes", "resources", "clock", "timing"),
    *("tools", "options"),
)


def rows() -> list[dict[str, Any]]:
    """What is stored: one of each module on each part."""
    found: list[dict[str, Any]] = json.loads(MEASURED.read_text())
    return found


@cache
def designs() -> dict[str, Design]:
    """The presets by the names of their cores."""
    found = (load(ROOT / "examples" / f"{preset}.toml").design for preset in PRESETS)
    return {design.name: design for design in found}


def design(row: dict[str, Any]) -> Design:
    """The preset of a row."""
    return designs()[row["name"].removesuffix("_axi")]


def line(found: dict[str, Any]) -> str:
    """Markdown of one preset on one part."""
    used = " | ".join(f"{found['resources'][key]['used']:,}" for key in ("LUT", "FF", "DSP", "BRAM"))
    if not (clock := found["clock"]):
        return f"| `{found['name']}` | {found['target']} | {found['mac_lanes']} | {used} |" + " |" * 9
    times = found["timing"]
    cells = [
        f"`{found['name']}`",
        found["target"],
        str(found["mac_lanes"]),
        used,
        fmax(clock),
        f"{times['latency_cycles']:,}",
        f"{times['interval_cycles']:,}",
        f"{times['latency_us']:,.1f} µs",
        f"{times['cut_through_us']:,.1f} µs" if found["package"] else "",
        f"{times['frame_latency_us']:,.1f} µs",
        f"{times['frames_per_second']:,.0f}",
        *(f"1/{1e3 * ms / times['frame_latency_us']:,.0f}" for ms in PUBLISHED_MS),
    ]
    return f"| {' | '.join(cells)} |"


def table() -> str:
    """Markdown of all rows, and the tools of them."""
    head = [
        "| module | part | MAC lanes | LUT | FF | DSP | BRAM | clock | first word, cycles "
        "| interval, cycles | first word | cut through | last word | frames/s | "
        + " | ".join(f"of {ms:g} ms" for ms in PUBLISHED_MS)
        + " |",
        "|---|---|" + "---:|" * 14,
    ]
    tools = {f"{name} {version}" for found in rows() for name, version in found["tools"].items()}
    return "\n".join([*head, *map(line, rows()), "", f"By {', '.join(sorted(tools))}."])


def main(directories: list[str]) -> None:
    """Read, store, publish."""
    found = {(row["name"], row["target"]): row for row in rows()}
    for directory in directories:
        report = json.loads((Path(directory) / SIDECAR).read_text())
        found[report["name"], report["target"]] = {key: report[key] for key in KEYS}
    kept = [row for _, row in sorted(found.items()) if row["netlist"] == current(row)]
    MEASURED.write_text(json.dumps(kept, indent=1) + "\n")
    insert("presets", table())


def current(row: dict[str, Any]) -> str:
    """The fingerprint of the Verilog of a row's preset, as it is now."""
    return fingerprint(modules(design(row), package=row["package"], pins=False).values())


if __name__ == "__main__":
    main(sys.argv[1:])
