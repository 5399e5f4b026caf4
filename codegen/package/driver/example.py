"""Calibrates a core, and prints the resultant force of frames: ``python example.py /dev/uio0 FRAMES``.

FRAMES is where output frames come from, whole, one after the other: a device of the DMA, or a file.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tfra_host import Bus, Core, Mapped, frame_bytes, parse_frame

FACTS = Path(__file__).parents[1] / "NAME.json"


def show(bus: Bus, source: Path, number: int) -> None:
    """Tare the core on ``bus``, and print ``number`` frames of ``source``."""
    facts = json.loads(FACTS.read_text(encoding="utf-8"))
    core = Core(bus, facts)
    core.tare(log2_frames=3)
    core.wait_tare()
    with source.open("rb") as file:
        for _ in range(number):
            frame = parse_frame(facts, file.read(frame_bytes(facts)))
            x, y, z = frame.resultant
            faults = ", ".join(sorted(frame.faults)) or "none"
            print(f"{frame.sequence}: {x:.4f} {y:.4f} {z:.4f} N, friction {frame.mu:.3f}, faults: {faults}")
    core.stop()


if __name__ == "__main__":
    show(Mapped(sys.argv[1]), Path(sys.argv[2]), number=10)
