"""SpTFRA: largest force error over the real products that filters F1, F2 and F3 leave (doi:10.3390/s24237829)."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tfra.model.boussinesq import operators
from tfra.model.choices import Adc, Choices
from tfra.model.converter import quantise
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.metrics import error_force
from tfra.model.tfra import Result, Tfra
from tfra.paper.picture import Columns, Picture, Text, legend_below, rounded
from tfra.paper.setups import DIRECTIONS, Setup
from tfra.paper.sparse import Filter, Kind, SparseDesign, filtered, multiplications
from tfra.report.colours import BLACK, BLUE, ORANGE, VERMILION

STRENGTHS: dict[Kind, tuple[float, ...]] = {
    "F1": (3, 7, 13, 25, 41, 51, 61, 81, 100),
    "F2": (0, 0.02, 0.1, 0.3, 1, 2, 3, 5, 10, 20, 30),
    "F3": (0, 0.1, 1, 3, 5, 10, 20),
}
"""F1: % of a row kept; F2, F3: threshold in % of the row's largest entry."""

PUBLISHED = {"normal": 12.6, "tangential": 7.7}
"""Errors in % of the published hardware, which takes 58.68 ms a frame."""

STYLES: dict[str, dict[str, Any]] = {
    "F1, float": {"color": VERMILION, "marker": "o"},
    "F2, float": {"color": BLUE, "marker": "s"},
    "F3, float": {"color": BLACK, "marker": "o", "markersize": 9, "linewidth": 0, "markerfacecolor": "none"},
    "F2, bit-accurate, mirror-folded": {"color": ORANGE, "marker": "x"},
}


def sptfra(setups: Sequence[Setup]) -> Picture:
    """Largest error of Eq. 35 in 24 directions over the products of a frame, for both contacts."""
    rows = [row for setup in setups for row in _rows(setup)]
    columns = rounded({key: np.array([row[key] for row in rows]) for key in rows[0]})
    text = Text(
        "Hardware with filtered matrices: 58.68 ms a frame, errors of 12.6 % (normal) and 7.7 % (tangential forces); "
        "the companion paper states 14.7 % as its largest error.",
        " ".join(_measured(setup, rows) for setup in setups),
        "The publication's contacts and its choice of matrices are not known, so its errors are lines to compare "
        "with, not a target. Errors do not fall steadily with more products: on one contact a filter may compensate "
        "other errors.",
    )
    return Picture("sptfra", "Sparse operators (SpTFRA)", columns, _draw(setups, columns), text)


def _measured(setup: Setup, rows: list[dict[str, Any]]) -> str:
    """Products and error with every entry kept, of the float and of the bit-accurate model."""
    whole = [row for row in rows if row["contact"] == setup.key and not row["strength_percent"]]
    listed = "; ".join(f"{r['series']}: {r['products']:,} products, {r['force_error_percent']:.2f} %" for r in whole)
    return f"{setup.title}, nothing filtered, products of a zero not counted: {listed}."


def _rows(setup: Setup) -> list[dict[str, Any]]:
    contacts = setup.contacts(DIRECTIONS)
    stress, forces = setup.stress(contacts), [contact.force for contact in contacts]
    sensor, full = setup.project.design.sensor, operators(setup.project.design.sensor)

    def row(series: str, strength: float, products: int, estimate: Result) -> dict[str, Any]:
        worst = float(error_force(forces, estimate.resultant).max())
        return {
            "contact": setup.key,
            "series": series,
            "strength_percent": strength,
            "products": products,
            "force_error_percent": worst,
        }

    rows = []
    for kind, strengths in STRENGTHS.items():
        for strength in strengths:
            chosen = Filter(kind, strength)
            ops = filtered(full, chosen)
            rows.append(row(f"{kind}, float", strength, multiplications(ops), Tfra(sensor, ops=ops)(stress)))
    for strength in STRENGTHS["F2"]:
        adc = Adc(16, setup.project.design.adc.full_scale)
        given = {f.name: getattr(setup.project.design, f.name) for f in fields(Choices)} | {"adc": adc}
        design = SparseDesign(**given, sparse=Filter("F2", strength))
        estimate = decode(design, FixedTfra(design)(quantise(design, stress)).words)
        rows.append(row("F2, bit-accurate, mirror-folded", strength, design.nonzero_products, estimate))
    return rows


def _draw(setups: Sequence[Setup], columns: Columns) -> Figure:
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    for axes, setup in zip(figure.subplots(1, len(setups), sharey=True), setups, strict=True):
        for series, style in STYLES.items():
            own = (columns["contact"] == setup.key) & (columns["series"] == series)
            x, y = columns["products"][own], columns["force_error_percent"][own]
            axes.plot(x, y, label=series, **{"linewidth": 1, **style})
        for (part, level), line in zip(PUBLISHED.items(), ("--", ":"), strict=True):
            axes.axhline(level, color=BLACK, linestyle=line, linewidth=1, label=f"published hardware, {part} forces")
        axes.set(title=setup.title, xscale="log", xlabel="real products of a frame")
    figure.axes[0].set(ylabel="largest force error, Eq. 35 / %", ylim=(0, None))
    legend_below(figure, figure.axes[0], 3)
    return figure
