"""Fig. 9: execution time for one frame, by the paper's loop, by this project's TFRA and by the two-variable search."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from tfra.model.arrays import Floats
from tfra.paper.literal import LiteralTfra
from tfra.paper.picture import Columns, Picture, Text, legend_below, stacked
from tfra.paper.setups import DIRECTIONS, Setup
from tfra.report.colours import BLUE, GREEN, VERMILION

SERIES = {
    "two-variable": ("two_variable_ms", VERMILION, "s"),
    "TFRA literal": ("literal_ms", GREEN, "^"),
    "TFRA": ("tfra_ms", BLUE, "o"),
}
"""By name: column, colour and marker."""

Model = Callable[[Floats], object]


def fig9(setups: Sequence[Setup], repeats: int, advance: Callable[[int], None]) -> Picture:
    """Median of ``repeats`` calls with one frame, in every direction; ``advance`` is called for each finished
    contact."""
    parts = {}
    for setup in setups:
        parts[setup.key] = _columns(setup, repeats)
        advance(1)
    columns = stacked(parts)
    text = Text(
        "In Matlab, longest times: TFRA 32.28 ms (Hertzian) and 27.13 ms (non-Hertzian), two-variable method 264.39 ms "
        "and 821.70 ms; so 8 and 30 times as long.",
        " ".join(_measured(setup.title, parts[setup.key]) for setup in setups),
        f"One machine, one run, medians of {repeats} calls with a single frame each: they change from run to run and "
        "compare programs in NumPy and SciPy, not methods in general. The published ratios are those of the paper's "
        "programs. The two-variable search here is this project's reading, which evaluates its functionals on a "
        "coarse grid at once and climbs with exact gradients: its time says nothing about the original's. The literal "
        "loop multiplies matrices for each candidate; TFRA here does so once a frame, with the same results.",
    )
    return Picture("fig9", "Execution time for one frame", columns, _draw(setups, parts, repeats), text)


def _columns(setup: Setup, repeats: int) -> Columns:
    design = setup.project.design
    stress = setup.stress(setup.contacts(DIRECTIONS))
    models: dict[str, Model] = {
        "two-variable": setup.engines["two-variable, own reading"],
        "TFRA literal": LiteralTfra(design.sensor, design.search.steps),
        "TFRA": setup.tfra,
    }
    columns: Columns = {"phi_ref_deg": np.array(DIRECTIONS)}
    for name, model in models.items():
        model(stress[:2])
        columns[SERIES[name][0]] = 1e3 * np.array([_median(model, frame[None], repeats) for frame in stress])
    return columns


def _median(model: Model, frame: Floats, repeats: int) -> float:
    """Median of ``repeats`` durations of a call, in seconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        model(frame)
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def _measured(title: str, columns: Columns) -> str:
    times = {name: columns[column] for name, (column, *_) in SERIES.items()}
    listed = ", ".join(f"{name} {np.median(each):.2f} ms ({each.max():.2f})" for name, each in times.items())
    slow, literal, fast = (float(np.median(each)) for each in times.values())
    return (
        f"{title}, median (longest) over the directions: {listed}. Ratios of medians: two-variable to literal "
        f"{slow / literal:.1f}, to TFRA {slow / fast:.1f}; literal to TFRA {literal / fast:.1f}."
    )


def _draw(setups: Sequence[Setup], parts: dict[str, Columns], repeats: int) -> Figure:
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    axes = figure.subplots(1, len(setups), sharey=True)
    for panel, letter, setup in zip(axes, "ab", setups, strict=True):
        for name, (column, color, marker) in SERIES.items():
            panel.plot(DIRECTIONS, parts[setup.key][column], marker=marker, color=color, linewidth=1, label=name)
        panel.set(title=f"({letter}) {setup.title}", xlabel=r"$\varphi_{ref}$ / °", xticks=range(0, 361, 45))
        panel.set_yscale("log")
        panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.yaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_minor_locator(NullLocator())
    axes[0].set_ylabel(f"time for one frame / ms\n(median of {repeats})")
    legend_below(figure, axes[0])
    return figure
