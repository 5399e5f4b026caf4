"""Cycles of a skin's frames over taxels and contacts, counted in Verilator; every word is compared with the model's.

``make skin_cycles`` writes ``bench/results/skin_cycles.json``, its plot, and the table in docs/skins.md; it takes half
an hour, nearly all of it for building simulators.
"""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.arrays import Ints
from tfra.model.choices import Architecture
from tfra.model.skin.finding import Finding
from tfra.model.skin.records import records
from tfra.model.skin.skin import Skin
from tfra.report.table import Table
from tfra.sim.run import simulate

SIDES = (16, 32, 64, 128)
CONTACTS = (1, 2, 4, 8, 16, 32)
FRAMES, SETTLED = 12, 3
"""Frames of each number of contacts, and the first intervals, in which the unit fills."""

PITCH = 8
"""Least distance of two contacts in taxels."""
RADIUS = 3.2
COLOURS = ("#0072B2", "#009E73", "#E69F00", "#D55E00")


def skin(side: int) -> Skin:
    """A square array around the window's core of the example on 64 lanes."""
    window = load(ROOT / "examples" / "fingers_32x32.toml").design.built_as(Architecture(64, 4))
    return Skin(replace(window.sensor, rows=side, columns=side), window, Finding(most=max(CONTACTS)))


def frame(of: Skin, count: int) -> Ints:
    """Codes of ``count`` round contacts of 37 taxels at places of a grid, from the middle of the array outwards."""
    side = of.sensor.rows
    centres = np.arange(PITCH // 2, side, PITCH)
    places = np.stack(np.meshgrid(centres, centres), axis=-1).reshape(-1, 2)
    nearest = np.argsort(np.hypot(*(places - side / 2).T), kind="stable")[:count]
    far = np.hypot(*(np.indices((side, side))[:, None] - places[nearest].T[:, :, None, None]))
    height = 0.5 * (1 << (of.adc.bits - 1)) * np.clip(1.4 - far / (2 * RADIUS), 0, 1) * (far < RADIUS + 0.5)
    codes: Ints = -np.rint(height.max(axis=0)).astype(np.int64)
    return codes


def measured(side: int) -> dict[int, int]:
    """Mean cycles from frame to frame by the number of contacts, of frames with as many."""
    of, found = skin(side), {}
    for count in (number for number in CONTACTS if number <= (side // PITCH) ** 2):
        codes = np.stack([frame(of, count)] * FRAMES)
        expected = records(of, codes, of.window.model.words)
        assert len(expected) == count * FRAMES
        run = simulate(of, codes, "verilator", expected=expected)
        assert (run.compared, run.mismatches) == (expected.size, 0)
        found[count] = round(float(run.interval[SETTLED:].mean()))
        print(f"{side}x{side}, {count} contact{'s' * (count > 1)}: {found[count]:,} cycles", flush=True)
    return found


def draw(every: dict[int, dict[int, int]]) -> None:
    """The plot of docs/skins.md: cycles over contacts, a line for each array."""
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    axes = figure.subplots()
    for (side, found), colour in zip(every.items(), COLOURS, strict=True):
        axes.plot(list(found), list(found.values()), "o-", color=colour, label=f"{side} × {side} taxels")
        axes.axhline(side * side, color=colour, linestyle=":", linewidth=1)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    axes.set_xticks(CONTACTS, [str(count) for count in CONTACTS])
    ticks = [1 << n for n in range(8, 16)]
    axes.set_yticks(ticks, [f"{tick:,}" for tick in ticks])
    axes.set_xlabel("contacts of a frame")
    axes.set_ylabel("cycles from frame to frame")
    axes.set_title("dotted: a taxel a cycle", fontsize="small", loc="right")
    axes.legend(frameon=False, fontsize="small")
    axes.grid(alpha=0.3)
    with mpl.rc_context({"svg.hashsalt": "tfra", "svg.fonttype": "none"}):
        figure.savefig(ROOT / "bench" / "results" / "skin_cycles.svg", metadata={"Date": None})


def table(every: dict[int, dict[int, int]]) -> str:
    """Markdown: a row for each array."""
    heads = ["taxels", *(f"{count} contact{'s' * (count > 1)}" for count in CONTACTS)]
    rows = [
        [f"{side}×{side}", *(f"{found[count]:,}" if count in found else "" for count in CONTACTS)]
        for side, found in every.items()
    ]
    return Table("", heads, rows, ()).markdown()


def main() -> None:
    """Measure and publish."""
    every = {side: measured(side) for side in SIDES}
    publish("skin_cycles", {str(side): found for side, found in every.items()}, table(every), "docs/skins.md")
    draw(every)


if __name__ == "__main__":
    main()
