"""The figure of docs/accuracy.md: friction found against the true one."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.accuracy.estimators import NAMES
from bench.accuracy.measure import BINS
from bench.accuracy.scenes import NOISES
from bench.publish import ROOT

COLOURS = ("#0072B2", "#CC79A7", "#E69F00", "#009E73", "#D55E00")
"""Of Okabe and Ito, one an estimator."""

TOP = 1.6
"""Largest friction found that is shown."""


def plot(curves: dict[str, Any]) -> None:
    """Write ``bench/results/accuracy.svg``: a row each noise, a panel each estimator."""
    mpl.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(14, 8.6), layout="constrained")
    panels = figure.subplots(len(NOISES), len(NAMES), sharex=True, sharey=True, squeeze=False)
    for row, noise in zip(panels, NOISES, strict=True):
        row[0].set_ylabel(f"{noise}\nμ found")
        for axes, name, colour in zip(row, NAMES, COLOURS, strict=True):
            panel(axes, np.array(curves[noise][name]), colour)
    for axes, name in zip(panels[0], NAMES, strict=True):
        axes.set_title(name)
    for axes in panels[-1]:
        axes.set_xlabel("true μ")
    panels[0][0].legend(loc="upper left", fontsize=9)
    figure.savefig(ROOT / "bench" / "results" / "accuracy.svg", metadata={"Date": None})


def panel(axes: Axes, percentiles: Any, colour: str) -> None:
    """Median and band of one estimator: ``percentiles (BINS, 3)``."""
    true, (low, middle, high) = (np.arange(BINS) + 0.5) / BINS, percentiles.T
    axes.plot([0, 1], [0, 1], "k--", lw=1, label="right")
    axes.fill_between(true, low, high, color=colour, alpha=0.25, lw=0, label="5 to 95 %")
    axes.plot(true, middle, "o-", color=colour, ms=4, lw=2, label="median")
    axes.set(xlim=(0, 1), ylim=(0, TOP), xticks=np.arange(0, 1.01, 0.2))
