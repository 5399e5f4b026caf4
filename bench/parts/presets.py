"""The presets on their parts: a table of what ``tfra synth`` has reported.

``python -m bench.parts.presets DIRECTORY ...`` reads the ``report.json`` of every directory that ``tfra synth PRESET
--out`` wrote, stores what the table needs in ``bench/results/presets.json`` beside what was there of other presets,
parts and tools, and writes the table in docs/measured.md.  It measures nothing itself: place and route takes minutes to
hours.
"""

import json
import sys
from pathlib import Path
from typing import Any

from bench.publish import ROOT, publish
from tfra.synth.run import SIDECAR

PUBLISHED_MS = (58.68, 32.28)
"""Time of a frame on SpTFRA's FPGA (doi:10.3390/s24237829), and the longest of TFRA in Matlab."""
KEYS = ("name", "target", "architecture", "mac_lanes", "resources", "clock", "timing", "tools", "options")


def row(found: dict[str, Any]) -> str:
    """Markdown of one preset on one part."""
    used = " | ".join(f"{found['resources'][key]['used']:,}" for key in ("LUT", "FF", "DSP", "BRAM"))
    clock, times = found["clock"], found["timing"]
    ratios = " | ".join(f"1/{1e3 * ms / times['frame_latency_us']:,.0f}" for ms in PUBLISHED_MS)
    cells = [
        f"`{found['name']}`",
        found["target"],
        str(found["mac_lanes"]),
        used,
        frequency(clock),
        f"{times['latency_cycles']:,}",
        f"{times['interval_cycles']:,}",
        f"{times['latency_us']:,.1f} µs",
        f"{times['frame_latency_us']:,.1f} µs",
        f"{times['frames_per_second']:,.0f}",
        ratios,
        tool(found),
    ]
    return f"| {' | '.join(cells)} |"


def frequency(clock: dict[str, Any]) -> str:
    """The median in MHz; a range only where there are several seeds."""
    median, seeds = f"{clock['median_mhz']:.1f}", clock["seeds"]
    if len(seeds) == 1:
        return f"{median} (seed {seeds[0]['seed']} alone)"
    return f"{median} ({clock['lowest_mhz']:.1f}–{clock['highest_mhz']:.1f}, {len(seeds)})"


def tool(found: dict[str, Any]) -> str:
    """Who placed and routed: a native program where its version is listed, else PyPI's."""
    name = "nextpnr-ecp5" if found["target"].startswith("ecp5") else "nextpnr-ice40"
    who, version = next((n, found["tools"][n]) for n in (name, f"yowasp-{name}") if n in found["tools"])
    return f"{who} {version.partition('+')[0]}"


def main(directories: list[str]) -> None:
    """Read, store, publish."""
    path = ROOT / "bench" / "results" / "presets.json"
    record = json.loads(path.read_text()) if path.exists() else {}
    for directory in directories:
        report = json.loads((Path(directory) / SIDECAR).read_text())
        record["{name} {target} ".format(**report) + tool(report)] = {key: report[key] for key in KEYS}
    lines = [
        "| preset | part | MAC lanes | LUT | FF | DSP | BRAM | MHz (lowest–highest, seeds) | first word, cycles "
        "| interval, cycles | first word | last word | frames/s | "
        + " | ".join(f"of {ms:g} ms" for ms in PUBLISHED_MS)
        + " | placed and routed by |",
        "|---|---|" + "---:|" * 13 + "---|",
        *(row(record[key]) for key in sorted(record)),
    ]
    publish("presets", record, "\n".join(lines))


if __name__ == "__main__":
    main(sys.argv[1:])
