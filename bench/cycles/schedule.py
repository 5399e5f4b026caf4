"""The schedule of the ``fast`` core as a Gantt chart, from the timeline that tests compare with RTL.

``python -m bench.cycles.schedule`` writes ``bench/results/schedule.png`` and ``.svg`` and the table of
docs/studies/schedule.md.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.publish import ROOT, insert
from tfra.codegen.config.read import load
from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.hdl.parallel.tfra.timeline.timeline import Timeline
from tfra.model.fixed.design import Design

UNITS = ("matvec", "dependent", "combine", "sweep", "gain", "scaling")
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""By frame, in turn."""
SHOWN = 7
"""Frames in the lower chart."""


def chart(axes: Axes, timeline: Timeline, begin: int, end: int) -> None:
    """The units' work between two cycles; a colour is a frame."""
    for span in timeline.spans:
        if span.unit not in UNITS or span.end <= begin or span.start >= end:
            continue
        row = UNITS.index(span.unit)
        start, color = max(span.start, begin), COLORS[span.frame % len(COLORS)]
        axes.barh(row, min(span.end, end) - start, left=start, height=0.7, color=color, lw=0.5, ec="w")
        if span.end - span.start > (end - begin) / 30:
            axes.text(start + 2, row, span.what, va="center", fontsize=6, color="w", clip_on=True)
    axes.set(yticks=range(len(UNITS)), yticklabels=UNITS, xlim=(begin, end))
    axes.invert_yaxis()
    axes.grid(axis="x", alpha=0.3)


def plot(design: Design, path: Path) -> None:
    """One frame alone above, frames back to back below."""
    timing = Parallel(design)
    frames = timing.stream.frames
    figure = Figure(figsize=(11, 5.4), layout="constrained")
    alone, stream = figure.subplots(2, 1)
    chart(alone, timing.alone, 0, timing.frame_latency + 10)
    alone.axvline(timing.latency, color="k", lw=1, ls=":")
    words = f"first word after {timing.latency} cycles, last after {timing.frame_latency}"
    alone.set_title(f"one frame: {words}", fontsize=9)
    begin = frames[8].b
    chart(stream, timing.stream, begin, begin + SHOWN * timing.initiation_interval // 2)
    interval = f"one in {timing.initiation_interval} cycles"
    stream.set_title(f"frames back to back: {interval}; a colour is a frame", fontsize=9)
    stream.set_xlabel("cycles")
    for suffix in (".png", ".svg"):
        figure.savefig(path.with_suffix(suffix), dpi=130, metadata={"Date": None} if suffix == ".svg" else None)


def table(design: Design) -> str:
    """Markdown: cycles in which a unit works for a frame."""
    timing = Parallel(design)
    lines = ["| unit | works for a frame, cycles | of the initiation interval |", "|---|---:|---:|"]
    for unit in UNITS:
        cycles = sum(span.end - span.start for span in timing.alone.spans if span.unit == unit)
        lines.append(f"| `{unit}` | {cycles:,} | {cycles / timing.initiation_interval:.0%} |")
    return "\n".join(lines)


def main() -> None:
    """Draw and publish."""
    mpl.rcParams.update({"font.size": 8, "svg.hashsalt": "tfra"})
    design = load(ROOT / "examples" / "fast.toml").design
    plot(design, ROOT / "bench" / "results" / "schedule.png")
    insert("schedule", table(design), "docs/studies/schedule.md")


if __name__ == "__main__":
    main()
