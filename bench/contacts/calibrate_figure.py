"""The figure of :mod:`.calibrate`: misfit over sizes and over the centre, and the directions that are found."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import matplotlib as mpl
import matplotlib.ticker
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.contacts.fits import Case, best, columns, estimates, misfit, placed
from bench.publish import ROOT
from tfra.model.arrays import Floats

ORANGE, BLUE = "#D55E00", "#0072B2"  # Okabe and Ito
LEVELS = (1, 1.5, 2, 2.5, 3, 4, 5, 7, 10)


def heat(axes: Axes, x: Floats, y: Floats, scores: Floats) -> None:
    """Misfit ``(len(y), len(x))`` in logarithmic colours with contours."""
    image = axes.pcolormesh(x, y, scores, cmap="cividis", norm="log", rasterized=True)
    axes.clabel(axes.contour(x, y, scores, LEVELS, colors="white", linewidths=0.7), fmt="{:g}".format, fontsize=7)
    bar = axes.figure.colorbar(image, ax=axes, label="misfit, rms in units of 1°, 0.01, 1 %")
    bar.ax.yaxis.set_major_locator(mpl.ticker.FixedLocator(LEVELS))
    bar.ax.yaxis.set_minor_locator(mpl.ticker.NullLocator())
    bar.ax.yaxis.set_major_formatter("{x:g}")


def sizes(axes: Axes, case: Case, result: dict[str, Any]) -> None:
    """Panel of the half sizes, centred."""
    chosen = best(result["fits"], "centred")
    heat(axes, case.half_x, case.half_y, result["scans"][chosen["shape"], chosen["sampling"]])
    axes.plot(*chosen["place"][:2], "*", color=ORANGE, ms=14, mec="white")
    axes.set(xlabel="half size along x / mm", ylabel="half size along y / mm")
    axes.set_title(f"{case.title}\n{chosen['shape']}, {chosen['sampling']} sampling, centred", fontsize=9)


def centres(axes: Axes, case: Case, result: dict[str, Any]) -> None:
    """Panel of the centre, at the sizes of the free fit; dashed: phi found where phi_ref = 0."""
    chosen = best(result["fits"], "free")
    a, b, *centre = chosen["place"]
    x, y = (np.linspace(-500, 500, 41) * pitch for pitch in (case.sensor.pitch_x, case.sensor.pitch_y))
    phi_ref, published = case.fitted
    contacts = placed(case, chosen["shape"], np.array([(a, b, u, v) for v, u in product(y, x)]))
    found = estimates(case.sensor, contacts, phi_ref, chosen["sampling"])
    heat(axes, x, y, misfit(found, published).reshape(41, 41))
    turn = (np.remainder(found[:, 0, 0] + 180, 360) - 180).reshape(41, 41)
    lines = axes.contour(x, y, turn, (-2, -1, -0.5, 0, 0.5, 1, 2), colors=ORANGE, linestyles="dashed", linewidths=1)
    axes.clabel(lines, fmt="{:g}°".format, fontsize=7)
    axes.plot(*centre, "*", color=ORANGE, ms=14, mec="white")
    axes.set(xlabel="centre off the middle along x / mm", ylabel="along y / mm")
    title = f"{chosen['shape']}, {chosen['sampling']} sampling, {a:.2f} × {b:.2f} mm\ndashed: φ found at φ_ref = 0°"
    axes.set_title(title, fontsize=9)


def directions(axes: Axes, case: Case, result: dict[str, Any]) -> None:
    """Panel of phi - phi_ref, published and of both fits."""
    phi_ref, published = case.published
    order = np.argsort(phi_ref)
    axes.plot(phi_ref[order], (published[:, 0] - phi_ref)[order], "ko", label="published", zorder=3)
    for name, color, line in (("centred", BLUE, "s-"), ("free", ORANGE, "^--")):
        found = columns(case, best(result["fits"], name))[:, 0]
        axes.plot(phi_ref[order], (found - phi_ref)[order], line, color=color, ms=5, label=f"best {name} fit")
    axes.axhline(0, color="grey", lw=0.7)
    axes.set(xlabel="φ_ref / °", ylabel="φ − φ_ref / °", xticks=np.arange(0, 91, 15))
    axes.set_title("directions; 65° was not fitted", fontsize=9)
    axes.legend(fontsize=8)


def plot(cases: Mapping[str, Case], results: Mapping[str, dict[str, Any]]) -> None:
    """Write ``bench/results/calibration.svg`` and ``.png``: a row for each case."""
    mpl.rcParams.update({"font.size": 9, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(14, 8), layout="constrained")
    for row, (name, case) in zip(figure.subplots(len(cases), 3), cases.items(), strict=True):
        for panel, axes in zip((sizes, centres, directions), row, strict=True):
            panel(axes, case, results[name])
    for ending, keep in (("svg", {"Date": None}), ("png", {"Software": None})):
        figure.savefig(ROOT / "bench" / "results" / f"calibration.{ending}", dpi=110, metadata=keep)
