"""Stated cycles against the gateware's: random arrays, lanes, words a cycle and steps of the sweep.

``python -m bench.cycles.timing [NUMBER]`` streams six frames back to back through NUMBER cores in Amaranth's simulator,
and compares the cycle of every taxel and of every result word with
:class:`tfra.hdl.parallel.tfra.timeline.timeline.Timeline`, the words with the model.  It writes
``bench/results/timing.json`` and the table in docs/studies/schedule.md, and exits with 1 if one differs.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from bench.cycles.streamed import random_design, stream
from bench.publish import publish
from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.model.cover.scenes import contact_codes

FRAMES = 6
SEEDS = range(100, 152)


def measure(seed: int) -> dict[str, Any]:
    """Stated cycles of one core, and how many measured ones, and words, differ."""
    design = random_design(seed)
    words, want, _, taken, cycles = stream(design, contact_codes(design, FRAMES, seed))
    timing = Parallel(design)
    frames = timing.timeline(FRAMES).frames
    late = sum(cycle != frame.taxel for cycle, frame in zip(taken - taken[0], frames, strict=True))
    for row, frame in zip(cycles - taken[0], frames, strict=True):
        late += sum(cycle != stated for cycle, stated in zip(row, frame.words, strict=True))
    return {
        "seed": seed,
        "array": f"{design.sensor.rows}×{design.sensor.columns}",
        "lanes": design.architecture.mac_lanes,
        "words": design.architecture.vector_words,
        "steps": design.search.steps,
        "latency": timing.latency,
        "frame_latency": timing.frame_latency,
        "interval": timing.initiation_interval,
        "compared": FRAMES + int(want.size),
        "late": int(late),
        "wrong": int((words != want).sum()),
    }


def main(number: int) -> int:
    """Measure, print, publish."""
    with ProcessPoolExecutor(2) as pool:
        rows = []
        for row in pool.map(measure, SEEDS[:number]):
            rows.append(row)
            print(row, flush=True)
    bad = sum(row["late"] + row["wrong"] > 0 for row in rows)
    lines = [
        f"{len(rows) - bad} of {len(rows)} random cores: every taxel and every word of {FRAMES} frames in its cycle.",
        "",
        "| array | MAC lanes | words a cycle | K | first word after | last word after | interval | compared | differ |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    keys = ("array", "lanes", "words", "steps", "latency", "frame_latency", "interval", "compared")
    lines += ["| " + " | ".join(str(row[key]) for key in keys) + f" | {row['late'] + row['wrong']} |" for row in rows]
    publish("timing", {"frames": FRAMES, "rows": rows}, "\n".join(lines), "docs/studies/schedule.md")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS)))
