"""How accurate every estimator is on identical frames, for any friction, under noise, and on what none expects.

``python -m bench.accuracy.accuracy`` writes ``bench/results/accuracy.json``, the figure beside it and the tables of
docs/accuracy.md, and the shortest in README.md.
"""

import argparse
import hashlib
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.accuracy import measure
from bench.accuracy.estimators import NAMES as ESTIMATORS
from bench.accuracy.scenes import NOISES, SEED, Case, cases
from bench.accuracy.tables import tables
from bench.publish import ROOT, insert, store
from tfra.codegen.config.write import millimetres
from tfra.model.learned.network import NAMES, Network

PAGE = "docs/accuracy.md"
SHORT = "accuracy short"
"""The table that README.md has, too."""
COUNT = 1000
"""Contacts a sensor."""

COLOURS = ("#0072B2", "#CC79A7", "#E69F00", "#009E73", "#D55E00")
"""Of Okabe and Ito, one an estimator."""

TOP = 1.6
"""Largest friction found that is shown."""


def record(every: Sequence[Case], count: int) -> dict[str, Any]:
    """All that is measured, in plain JSON types."""
    observed = {case.name: measure.observe(case, count) for case in every}
    together = measure.pooled(observed.values())
    sensors = {
        case.name: {
            **described(case),
            "scenes": measure.percentiles(observed[case.name]),
            "fixed": measure.agreement(case, count),
            "paper": measure.paper(case) if case.name in measure.PAPER else None,
        }
        for case in every
    }
    pooled, curves = measure.percentiles(together), measure.curves(together)
    return {"seed": SEED, "contacts": count, "sensors": sensors, "pooled": pooled, "curves": curves}


def described(case: Case) -> dict[str, Any]:
    """What the page says of a sensor and its network."""
    sensor, weights = case.design.sensor, case.design.weights
    return {
        "taxels": [sensor.rows, sensor.columns],
        "pitch_mm": [millimetres(sensor.pitch_x), millimetres(sensor.pitch_y)],
        "thickness_mm": millimetres(sensor.thickness),
        "pitch_over_thickness": round(case.coarseness, 3),
        "units": list(weights.counts),
        "products": Network(sensor, weights).products,
        "weights_sha256": hashlib.sha256(b"".join(getattr(weights, name).tobytes() for name in NAMES)).hexdigest(),
    }


def plot(curves: dict[str, Any]) -> None:
    """Write ``bench/results/accuracy.svg``: a row each noise, a panel each estimator."""
    mpl.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(14, 8.6), layout="constrained")
    panels = figure.subplots(len(NOISES), len(ESTIMATORS), sharex=True, sharey=True, squeeze=False)
    for row, noise in zip(panels, NOISES, strict=True):
        row[0].set_ylabel(f"{noise}\nμ found")
        for axes, name, colour in zip(row, ESTIMATORS, COLOURS, strict=True):
            panel(axes, np.array(curves[noise][name]), colour)
    for axes, name in zip(panels[0], ESTIMATORS, strict=True):
        axes.set_title(name)
    for axes in panels[-1]:
        axes.set_xlabel("true μ")
    panels[0][0].legend(loc="upper left", fontsize=9)
    figure.savefig(ROOT / "bench" / "results" / "accuracy.svg", metadata={"Date": None})


def panel(axes: Axes, percentiles: Any, colour: str) -> None:
    """Median and band of one estimator: ``percentiles (BINS, 3)``."""
    true, (low, middle, high) = (np.arange(measure.BINS) + 0.5) / measure.BINS, percentiles.T
    axes.plot([0, 1], [0, 1], "k--", lw=1, label="right")
    axes.fill_between(true, low, high, color=colour, alpha=0.25, lw=0, label="5 to 95 %")
    axes.plot(true, middle, "o-", color=colour, ms=4, lw=2, label="median")
    axes.set(xlim=(0, 1), ylim=(0, TOP), xticks=np.arange(0, 1.01, 0.2))


def main() -> None:
    """Measure and write everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=COUNT, help="random contacts of each sensor")
    found = record(cases(), parser.parse_args().contacts)
    store("accuracy", found)
    plot(found["curves"])
    for name, table in tables(found).items():
        insert(name, table, PAGE)
        if name == SHORT:
            insert(name, table, "README.md")


if __name__ == "__main__":
    main()
