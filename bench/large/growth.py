"""Growth of a core with the array: cycles, products, coefficients and block memories from 4x4 to 32x32.

``python -m bench.large.growth`` writes ``bench/results/growth.json``, ``bench/results/growth.png`` and the tables of
docs/studies/growth.md.  Cycles are those of :class:`tfra.hdl.parallel.tfra.parallel.Parallel`, which tests compare with
the gateware.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from bench.publish import ROOT, insert, store
from tfra.hdl.parallel.matvec.images import depth
from tfra.hdl.parallel.tfra.parallel import Parallel
from tfra.model.choices import Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.estimate import estimate
from tfra.synth.targets import find

SIZES = (4, 8, 10, 16, 20, 32)
LANES = (16, 64)
WORDS, WORD_BITS = 1024, 18
"""Of one block memory: DP16KD of ECP5, half a RAMB36E1 of 7-series."""
DEVICES = {"ECP5-25": 56, "ECP5-45": 108, "ECP5-85": 208, "Artix-7 200T": 730}
"""Block memories of 18 kbit."""
STORED = 8
"""Operators of Q x Q coefficients for each of the four parities."""


def square(size: int, lanes: int) -> Design:
    """A core of ``size x size`` taxels at 4 mm under 3 mm."""
    sensor = SensorArray(size, size, 4e-3, 4e-3, 3e-3)
    return TfraDesign(sensor, architecture=Architecture(lanes))


def estimated(design: Design) -> dict[str, int]:
    """LUTs and block memories of the whole core on an ECP5, on paper."""
    total = estimate(replace(design, target="ecp5"), find("ecp5-85").family).total
    return {name: total[name] for name in ("LUT", "BRAM")}


def measure(size: int, lanes: int) -> dict[str, Any]:
    """Numbers of one core."""
    design = square(size, lanes)
    timing = Parallel(design)
    return {
        "size": size,
        "lanes": design.architecture.mac_lanes,
        "products": design.multiplications,
        "latency": timing.frame_latency,
        "interval": timing.initiation_interval,
        "bits": design.coefficient_bits,
        "blocks": design.architecture.mac_lanes * -(-depth(design) // WORDS),
        "vector": design.widths.vector,
        "estimated": estimated(design),
    }


def bits(size: int) -> int:
    """Coefficient bits of a square array, by hand: operators and four quads of rows that sum."""
    quads = ((size + 1) // 2) ** 2
    return 4 * quads * (STORED * quads + 4) * WORD_BITS


def largest(blocks: int) -> int:
    """The largest square array whose coefficients fill ``blocks`` memories or fewer."""
    size = 2
    while bits(size + 1) <= blocks * WORDS * WORD_BITS:
        size += 1
    return size


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: one row for each core."""
    lines = [
        "| array | MAC lanes | real products | last word after | interval | frames/s at 100 MHz | coefficients, kbit "
        "| coefficient blocks | vector bits | LUT, blocks in all, estimated |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        whole = ", ".join(f"{value:,}" for value in row["estimated"].values())
        lines.append(
            f"| {row['size']}×{row['size']} | {row['lanes']} | {row['products']:,} | {row['latency']:,} "
            f"| {row['interval']:,} | {1e8 / row['interval']:,.0f} | {row['bits'] / 1000:,.0f} | {row['blocks']:,} "
            f"| {row['vector']} | {whole} |"
        )
    return "\n".join(lines)


def limit_table() -> str:
    """Markdown: where the memory ends."""
    lines = ["| device | 18-kbit blocks | largest square array |", "|---|---:|---:|"]
    for name, blocks in DEVICES.items():
        lines.append(f"| {name} | {blocks} | {largest(blocks)}×{largest(blocks)} |")
    return "\n".join(lines)


def plot(rows: list[dict[str, Any]]) -> None:
    """Memory and time over taxels."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    memory, time = figure.subplots(1, 2, sharex=True)
    first = [row for row in rows if row["lanes"] == LANES[0]]
    taxels = [row["size"] ** 2 for row in first]
    memory.plot(taxels, [row["bits"] / 1e3 for row in first], "o-", color="#0072B2", label="coefficients")
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
