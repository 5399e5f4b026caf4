"""The presets on their parts: a table of what ``tfra synth`` has reported.

``python -m bench.presets DIRECTORY ...`` reads the ``report.json`` of every directory that ``tfra synth PRESET --out``
wrote, stores what the table needs in ``bench/results/presets.json`` beside what was there of other presets, and writes
the table in README.md.  It measures nothing itself: place and route of a large core takes from minutes to hours.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from bench.c_speed import PUBLISHED
from bench.publish import ROOT, publish
from tfra.synth.run import SIDECAR

KEYS = ("target", "architecture", "mac_lanes", "resources", "clock", "timing", "tools")


def row(name: str, found: dict[str, Any]) -> str:
    """Markdown of one preset."""
    used = " | ".join(f"{found['resources'][key]['used']:,}" for key in ("LUT", "FF", "DSP", "BRAM"))
    clock, times = found["clock"], found["timing"]
    spread = f"{clock['median_mhz']:.1f} ({clock['lowest_mhz']:.1f}–{clock['highest_mhz']:.1f}, {len(clock['seeds'])})"
    ratios = " | ".join(f"1/{us / times['frame_latency_us']:,.0f}" for us, _ in PUBLISHED.values())
    return (
        f"| `{name}` | {found['target']} | {found['mac_lanes']} | {used} | {spread} | {times['latency_cycles']:,} "
        f"| {times['latency_us']:,.1f} µs | {times['frame_latency_us']:,.1f} µs | {times['frames_per_second']:,.0f} "
        f"| {ratios} |"
    )


def main(directories: list[str]) -> None:
    """Read, store, publish."""
    path = ROOT / "bench" / "results" / "presets.json"
    record = json.loads(path.read_text()) if path.exists() else {}
    for directory in directories:
        report = json.loads((Path(directory) / SIDECAR).read_text())
        record[report["name"]] = {key: report[key] for key in KEYS}
    lines = [
        "| preset | part | MAC lanes | LUT | FF | DSP | BRAM | MHz (lowest–highest, seeds) | first word, cycles "
        "| first word | last word | frames/s | "
        + " | ".join(f"of {us / 1e3:g} ms" for us, _ in PUBLISHED.values())
        + " |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
        *(row(name, found) for name, found in sorted(record.items())),
    ]
    publish("presets", record, "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1:])
