"""The table of placed skins in docs/skins.md: ``python -m bench.parts.skins DIR...`` of what ``tfra synth`` wrote.

The CONFIG of each is that of the example with its own taxels and contacts, 64 lanes and cells of ECP5.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from bench.publish import publish

RESOURCES = ("LUT", "DSP", "BRAM")


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: a row for each skin."""
    lines = [
        f"| taxels, contacts | part | {', '.join(RESOURCES)} | MHz | cycles | frames/s | µs to the last word |",
        "|---|---|---|---:|---:|---:|---:|",
    ]
    for row in rows:
        found, times = row["resources"], row["timing"]
        used = ", ".join(f"{found[name]['used']:,} ({found[name]['percent']:g} %)" for name in RESOURCES)
        lines.append(
            f"| {row['taxels']}, {times['contacts']} | {row['target']} | {used} | {row['clock']['median_mhz']:.1f} "
            f"| {times['interval_cycles']:,} | {times['frames_per_second']:,.0f} | {times['frame_latency_us']:.1f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Read the reports and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("directory", nargs="+", type=Path)
    kept = ("target", "resources", "clock", "timing", "tools", "netlist")
    rows = []
    for directory in parser.parse_args().directory:
        report = json.loads((directory / "report.json").read_text())
        rows.append({"taxels": directory.name, **{key: report[key] for key in kept}})
    publish("skin_parts", {"rows": rows}, table(rows), "docs/skins.md")


if __name__ == "__main__":
    main()
