"""Pictures of a calibration, as parts of a page: the same numbers give the same bytes."""

import io
import math
from collections.abc import Callable
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from tfra.calibrate.calibrated import Calibrated
from tfra.calibrate.response import Presses, Response
from tfra.model.arrays import Floats
from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE, VERMILION
from tfra.report.html import image

STYLE: Any = {"font.size": 9, "axes.titlesize": 10, "svg.hashsalt": "tfra", "svg.fonttype": "path"}

MOST_LOADS = 48
"""Maps of residuals that a page shows: those of the loads with the largest ones."""

NARROW = 8
"""Presses whose spread is drawn: those with the smallest contacts."""


def pictures(found: Calibrated) -> dict[str, str]:
    """Each picture by its heading, as HTML."""
    drawn: dict[str, Callable[[Calibrated], Figure]] = {
        "Gains of the taxels": _gains,
        "Forces that the loads show": _forces,
        "Spread of the stress": _spread,
        "What the model leaves of each load": _residuals,
    }
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        return {title: _image(draw(found), title) for title, draw in drawn.items()}


def _image(figure: Figure, label: str) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None})
    return image(label, stream.getvalue())


def _map(axes: Any, values: Floats, limits: tuple[float, float], colours: str) -> Any:
    """A map of the array: x to the right, y up."""
    return axes.imshow(values, origin="lower", vmin=limits[0], vmax=limits[1], cmap=colours)


def _gains(found: Calibrated) -> Figure:
    figure = Figure(figsize=(8.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    gain = np.where(found.dead, np.nan, found.gain)
    far = float(np.nanmax(np.abs(gain / found.common - 1)))
    shown = _map(left, gain, (found.common * (1 - far), found.common * (1 + far)), "PuOr")
    figure.colorbar(shown, ax=left, label="gain")
    error = np.where(found.dead, np.nan, 100 * found.gain_error)
    shown = _map(right, error, (0.0, float(np.nanmax(error))), "viridis_r")
    figure.colorbar(shown, ax=right, label="standard error of the gain / %")
    x, y = (found.fit.place / (found.array.sensor.pitch_x, found.array.sensor.pitch_y)).T
    press = np.array([bool(load.normal) for load in found.loads])
    right.plot(x[press], y[press], "+", color=VERMILION, label="press")
    for axes in (left, right):
        rows, columns = np.nonzero(found.dead)
        axes.plot(columns, rows, "x", color=BLACK, label="dead")
        axes.set(xlabel="column", ylabel="row")
        axes.set_xlim(-0.5, found.shape[1] - 0.5)
        axes.set_ylim(-0.5, found.shape[0] - 0.5)
    right.legend(loc="upper right", fontsize=7)
    return figure


def _forces(found: Calibrated) -> Figure:
    figure = Figure(figsize=(8.5, 3.2), layout="constrained")
    axes = figure.subplots()
    normal = np.array([load.normal for load in found.loads])
    back = np.array([load.unloading for load in found.loads])
    pulled = np.array([load.tangential > 0 for load in found.loads])
    for which, marker, colour, label in (
        (~back & ~pulled, "o", BLUE, "normal"),
        (back, "v", ORANGE, "unloading"),
        (pulled & ~back, "^", GREEN, "with a tangential part"),
    ):
        if (which & (normal > 0)).any():
            part = which & (normal > 0)
            axes.plot(normal[part], 100 * (found.shown[part] - 1), marker, color=colour, label=label)
    axes.axhline(0, color=BLACK, linewidth=0.8)
    axes.set_xscale("log")
    axes.set(xlabel="force of the table / N", ylabel="shown less given / %")
    axes.legend(fontsize=7)
    return figure


def _spread(found: Calibrated) -> Figure:
    """Stress over the distance from a press, with the layer that fits and with that of CONFIG."""
    figure = Figure(figsize=(8.5, 3.6), layout="constrained")
    axes = figure.subplots()
    sensor, fit = found.array.sensor, found.fit
    force = np.array([load.normal for load in found.loads])
    narrow = np.argsort(np.where(force > 0, fit.radius, np.inf))[: min(NARROW, int((force > 0).sum()))]
    x, y = sensor.positions()
    area = math.pi * fit.thickness**2
    for at in narrow:
        told = found.told.told[at]
        distance = np.hypot(x - fit.place[at, 0], y - fit.place[at, 1])[told]
        stress = -(found.told.value[at] / fit.sensitivity)[told] * area / (force[at] * fit.scale[at])
        axes.plot(1e3 * distance, stress, ".", color=BLUE, markersize=3, label="readings" if at == narrow[0] else None)
    radius = float(np.median(fit.radius[narrow]))
    for thickness, style, label in (
        (fit.thickness, "-", f"fitted, {1e3 * fit.thickness:.3g} mm"),
        (sensor.thickness, "--", f"of CONFIG, {1e3 * sensor.thickness:.3g} mm"),
    ):
        at, stress = _profile(found, thickness, radius)
        axes.plot(1e3 * at, stress * area, style, color=VERMILION, label=label)
    axes.set_xlim(0, 1e3 * 5 * fit.thickness)
    axes.set(xlabel="distance from the press / mm", ylabel="stress π h² / force")
    axes.legend(fontsize=7)
    return figure


def _profile(found: Calibrated, thickness: float, radius: float) -> tuple[Floats, Floats]:
    """Distances in m, and compression per newton there, 1/m^2, of a press with this ``radius`` in the middle."""
    sensor = found.array.sensor
    steps = np.linspace(0.0, 5 * found.fit.thickness, 120)
    count = len(steps)
    middle = sensor.columns // 2 * sensor.pitch_x, sensor.rows // 2 * sensor.pitch_y
    force = np.tile([0.0, 0.0, -1.0], (count, 1))
    presses = Presses(
        middle[0] + steps, np.full(count, middle[1]), np.full(count, np.log(radius)), force, np.zeros(count, np.bool_)
    )
    response = Response(sensor, found.fit.margin or 5 * found.fit.thickness)
    taxel = sensor.rows // 2 * sensor.columns + sensor.columns // 2
    return steps, -response(math.log(thickness), found.fit.poisson, presses).value[:, taxel]


def _residuals(found: Calibrated) -> Figure:
    worst = np.argsort(-np.abs(found.residual).max(axis=(1, 2)), kind="stable")[:MOST_LOADS]
    chosen = np.sort(worst)
    across = min(8, len(chosen))
    down = -(-len(chosen) // across)
    (rows, columns), gap = found.shape, 1 + max(found.shape) // 6
    mosaic = np.full((down * (rows + gap), across * (columns + gap)), np.nan)
    figure = Figure(figsize=(8.5, 1.0 + 8.0 * len(mosaic) / mosaic.shape[1]))
    axes = figure.add_axes((0.01, 0.02, 0.86, 0.96))
    limit = max(1.0, 100 * float(np.abs(found.residual).max()))
    for place, at in enumerate(chosen):
        row, column = (down - 1 - place // across) * (rows + gap), place % across * (columns + gap)
        mosaic[row : row + rows, column : column + columns] = 100 * found.residual[at]
        axes.text(column - 0.5, row + rows - 0.3, found.loads[at].recording[:14], fontsize=6, va="bottom")
    shown = _map(axes, mosaic, (-limit, limit), "RdBu")
    axes.set_axis_off()
    figure.colorbar(shown, cax=figure.add_axes((0.9, 0.1, 0.02, 0.8)), label="% of the peak")
    return figure
