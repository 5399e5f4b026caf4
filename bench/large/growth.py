"""How a core grows with the array: cycles, products, coefficients and block memories from 4x4 to 32x32.

``python -m bench.large.growth`` writes ``bench/results/growth.json``, ``bench/results/growth.png`` and the tables of
docs/studies/growth.md.  Cycles are those of :class:`tfra.hdl.parallel.tfra.timing.Timing`, which tests compare with the
gateware.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import matplotlib as mpl
from matplotlib.figure import Figure

from bench.publish import ROOT, insert, store
from tfra.hdl.parallel.matvec.images import depth
from tfra.hdl.parallel.tfra.timing import Timing
from tfra.model.design import Architecture, Design, Form
from tfra.model.fixed.coefficients import coefficient_bits
from tfra.model.fixed.widths import widths
from tfra.model.sensor import SensorArray
from tfra.synth.estimate import estimate
from tfra.synth.targets import find

SIZES = (4, 8, 10, 16, 20, 32)
LANES = (16, 64)
WORDS, WORD_BITS = 1024, 18
"""Of one block memory: DP16KD of ECP5, half a RAMB36E1 of 7-series."""
DEVICES = {"ECP5-25": 56, "ECP5-45": 108, "ECP5-85": 208, "Artix-7 200T": 730}
"""Block memories of 18 kbit."""
STORED = {"pinv": 8, "gram": 6}
"""Operators of Q x Q coefficients for each of the four parities."""


def square(size: int, lanes: int, operators: Form = "pinv") -> Design:
    """A core of ``size x size`` taxels at 4 mm under 3 mm."""
    sensor = SensorArray(size, size, 4e-3, 4e-3, 3e-3)
    return Design(sensor, architecture=Architecture(lanes), operators=operators)


def estimated(design: Design) -> dict[str, int]:
    """LUTs and block memories of the whole core on an ECP5, on paper."""
    total = estimate(replace(design, target="ecp5"), find("ecp5-85").family).total
    return {name: total[name] for name in ("LUT", "BRAM")}


def measure(size: int, lanes: int) -> dict[str, Any]:
    """Numbers of one core."""
    design = square(size, lanes)
    timing = Timing(design)
    return {
        "size": size,
        "lanes": design.architecture.mac_lanes,
        "products": timing.multiplications,
        "latency": timing.frame_latency,
        "interval": timing.initiation_interval,
        "bits": {form: coefficient_bits(replace(design, operators=form)) for form in get_args(Form)},
        "blocks": design.architecture.mac_lanes * -(-depth(design) // WORDS),
        "vector": widths(design).vector,
        "estimated": estimated(design),
    }


def bits(size: int, form: Form) -> int:
    """Coefficient bits of a square array, by hand: operators and four quads of rows that sum."""
    quads = ((size + 1) // 2) ** 2
    return 4 * quads * (STORED[form] * quads + 4) * WORD_BITS


def largest(blocks: int, form: Form) -> int:
    """The largest square array whose coefficients fill ``blocks`` memories or fewer."""
    size = 2
    while bits(size + 1, form) <= blocks * WORDS * WORD_BITS:
        size += 1
    return size


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: one row for each core."""
    lines = [
        "| array | MAC lanes | real products | last word after | interval | frames/s at 100 MHz | coefficients, kbit: "
        "`pinv`, `gram` | coefficient blocks | vector bits | LUT, blocks in all, estimated |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        whole = ", ".join(f"{value:,}" for value in row["estimated"].values())
        kbit = ", ".join(f"{value / 1000:,.0f}" for value in row["bits"].values())
        lines.append(
            f"| {row['size']}×{row['size']} | {row['lanes']} | {row['products']:,} | {row['latency']:,} "
            f"| {row['interval']:,} | {1e8 / row['interval']:,.0f} | {kbit} | {row['blocks']:,} | {row['vector']} "
            f"| {whole} |"
        )
    return "\n".join(lines)


def limit_table() -> str:
    """Markdown: where the memory ends."""
    lines = ["| device | 18-kbit blocks | largest square array, `pinv` | `gram` |", "|---|---:|---:|---:|"]
    for name, blocks in DEVICES.items():
        sizes = " | ".join(f"{largest(blocks, form)}×{largest(blocks, form)}" for form in get_args(Form))
        lines.append(f"| {name} | {blocks} | {sizes} |")
    return "\n".join(lines)


def plot(rows: list[dict[str, Any]]) -> None:
    """Memory and time over taxels."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    memory, time = figure.subplots(1, 2, sharex=True)
    first = [row for row in rows if row["lanes"] == LANES[0]]
    taxels = [row["size"] ** 2 for row in first]
    for form, color in zip(get_args(Form), ("#0072B2", "#D55E00"), strict=True):
        memory.plot(taxels, [row["bits"][form] / 1e3 for row in first], "o-", color=color, label=f"stored: {form}")
    for name, blocks in DEVICES.items():
        memory.axhline(blocks * WORDS * WORD_BITS / 1e3, color="grey", ls=":", lw=1)
        memory.text(taxels[0], blocks * WORDS * WORD_BITS / 1e3, name, fontsize=7, va="bottom")
    memory.set(xlabel="taxels m", ylabel="coefficients / kbit", xscale="log", yscale="log")
    for lanes, color in zip(LANES, ("#0072B2", "#D55E00"), strict=True):
        own = [row for row in rows if row["lanes"] == lanes]
        cycles = [row["interval"] for row in own]
        time.plot([row["size"] ** 2 for row in own], cycles, "s-", color=color, label=f"{lanes} MAC lanes")
    time.axhline(1e5, color="grey", ls=":", lw=1)
    time.text(taxels[0], 1e5, "1,000 frames/s at 100 MHz", fontsize=7, va="bottom")
    time.set(xlabel="taxels m", ylabel="initiation interval / cycles", xscale="log", yscale="log")
    for axes in (memory, time):
        axes.legend(fontsize=8, loc="lower right")
    figure.savefig(ROOT / "bench" / "results" / "growth.png", dpi=110, metadata={"Software": None})


def main() -> None:
    """Compute, print, write the JSON, the tables and the plot."""
    rows = [measure(size, lanes) for size in SIZES for lanes in LANES if lanes <= size**2]
    store("growth", {"rows": rows})
    plot(rows)
    insert("growth", table(rows), "docs/studies/growth.md")
    insert("limits", limit_table(), "docs/studies/growth.md")


if __name__ == "__main__":
    main()
