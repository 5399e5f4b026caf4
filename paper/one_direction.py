"""Figs. 2 and 4: one contact with one direction of its tangential force.

Fig. 2 is the normal stress and the centroids of compression and traction (Eqs. 19-22), Fig. 4 the objective functions
B^z (Eq. 23) and B^xy (Eq. 25) over the independent friction coefficient.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from tfra.model.arrays import Floats
from tfra.paper.picture import STRESS_MAP, Columns, Picture, Text, rounded
from tfra.paper.setups import Setup
from tfra.report.colours import BLACK, BLUE, ORANGE, VERMILION

PHI = 45
"""Direction of the tangential force, in degrees; the paper does not say its own."""


def fig2(setup: Setup) -> Picture:
    """The stress surface and its map with both centroids."""
    stress = setup.stress(setup.contacts([PHI]))[0]
    x, y = setup.project.design.sensor.positions()
    parts = (np.minimum(stress, 0).ravel(), np.maximum(stress, 0).ravel())
    compression, traction = (np.asarray([part @ x, part @ y]) / float(part.sum()) for part in parts)
    compression, traction = rounded({"c": compression, "t": traction}).values()
    step = compression - traction
    phi = float(np.degrees(np.arctan2(step[1], step[0])))
    columns = rounded({"x_mm": 1e3 * x, "y_mm": 1e3 * y, "b_z_kPa": 1e-3 * stress.ravel()})
    text = Text(
        "The stress surface of a Hertzian contact with the centroids of traction and compression; no numbers.",
        f"Compression to {columns['b_z_kPa'].min():.1f} kPa, traction to {columns['b_z_kPa'].max():.1f} kPa. "
        f"Centroids: compression ({1e3 * compression[0]:.2f}, {1e3 * compression[1]:.2f}) mm, "
        f"traction ({1e3 * traction[0]:.2f}, {1e3 * traction[1]:.2f}) mm; their direction is {phi:.2f}° "
        f"for a force towards {PHI}°.",
        "The tangential force pushes material ahead of the contact (compression) and pulls behind it (traction), so "
        "the line from the traction centroid to the compression centroid shows where the force points.",
    )
    title = f"Stress surface with its centroids, {setup.title}, φ = {PHI}°"
    return Picture("fig2", title, columns, _draw_stress(setup, columns, compression, traction), text)


def _draw_stress(setup: Setup, columns: Columns, compression: Floats, traction: Floats) -> Figure:
    sensor = setup.project.design.sensor
    x, y, stress = (c.reshape(sensor.rows, sensor.columns) for c in columns.values())
    norm = TwoSlopeNorm(0, stress.min(), stress.max())
    figure = Figure(figsize=(9.5, 4.0), layout="constrained")
    surface = figure.add_subplot(1, 2, 1, projection="3d")
    surface.plot_surface(x, y, stress, cmap=STRESS_MAP, norm=norm, edgecolor=BLACK, linewidth=0.3)
    surface.set(xlabel="x / mm", ylabel="y / mm", zlabel="$b_z$ / kPa", xticks=range(0, 40, 10), yticks=range(0, 20, 5))
    surface.view_init(elev=28, azim=-60)
    surface.set_box_aspect((1.6, 1.2, 1.0), zoom=1.1)
    flat = figure.add_subplot(1, 2, 2)
    image = flat.pcolormesh(x, y, stress, cmap=STRESS_MAP, norm=norm, rasterized=True)
    ticks = [*np.arange(20 * np.ceil(stress.min() / 20), 1, 20), stress.max()]
    bar = figure.colorbar(image, ax=flat, location="bottom", ticks=ticks, format="%.3g")
    bar.set_label("$b_z$ / kPa, a scale for each sign")
    flat.set(xlabel="x / mm", ylabel="y / mm", aspect="equal")
    flat.grid(False)
    _centroids(flat, 1e3 * compression, 1e3 * traction)
    return figure


def _centroids(axes: Axes, compression: Floats, traction: Floats) -> None:
    arrow = {"arrowstyle": "-|>", "color": BLACK, "linewidth": 1.2}
    axes.annotate("", tuple(compression), tuple(traction), arrowprops=arrow)
    axes.plot(*traction, "s", color=VERMILION, markeredgecolor="white", markersize=8, label="traction centroid")
    axes.plot(*compression, "o", color=BLUE, markeredgecolor="white", markersize=8, label="compression centroid")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02), ncols=2)


def fig4(setup: Setup) -> Picture:
    """Both functions over the whole sweep, the plateau of minima, and the choice."""
    result = setup.tfra(setup.stress(setup.contacts([PHI])), keep_sweep=True)
    sweep, chosen = result.sweep, int(result.sweep_index[0])
    assert sweep is not None
    plateau = sweep.plateau[0].astype(int)
    curves = {"mu_ind": sweep.mu[0], "B_z_kPa": 1e-3 * sweep.b_z[0], "B_xy_kPa": 1e-3 * sweep.b_xy[0]}
    columns = rounded(curves | {"plateau": plateau})
    inside = sweep.mu[0][plateau == 1]
    text = Text(
        "Both functions against the independent friction coefficient, with more than one minimum of B^z; no numbers.",
        f"B^z is smallest at {len(inside)} of {len(plateau)} candidates, μ_ind from {inside[0]:.2f} to "
        f"{inside[-1]:.2f} (value {columns['B_z_kPa'].min():.3g} kPa); among them B^xy is smallest, "
        f"{columns['B_xy_kPa'][chosen]:.3g} kPa, at μ_ind = {sweep.mu[0, chosen]:.2f}.",
        "B^z is convex and piecewise linear in μ_ind, so its minima form one interval, inside which B^xy decides. "
        "Where that is an end of the interval, how exactly B^z leaves its minimum decides the result.",
    )
    title = f"Objective functions, {setup.title}, φ = {PHI}°"
    return Picture("fig4", title, columns, _draw_sweep(columns, chosen), text)


def _draw_sweep(columns: Columns, chosen: int) -> Figure:
    mu, plateau = columns["mu_ind"], columns["mu_ind"][columns["plateau"] == 1]
    figure = Figure(figsize=(6.5, 4.6), layout="constrained")
    panels = figure.subplots(2, 1, sharex=True)
    curves = (("B_z_kPa", "$B^z$ / kPa", BLUE), ("B_xy_kPa", "$B^{xy}$ / kPa", BLACK))
    for axes, (name, label, color) in zip(panels, curves, strict=True):
        axes.axvspan(plateau[0], plateau[-1], color=ORANGE, alpha=0.3, linewidth=0, label="minima of $B^z$")
        axes.plot(mu, columns[name], color=color)
        axes.plot(mu[chosen], columns[name][chosen], "o", color=VERMILION, markersize=7, label="chosen")
        axes.set(ylabel=label, xlim=(mu[0], mu[-1]))
        axes.legend()
    panels[-1].set_xlabel(r"independent friction coefficient $\mu_{ind}$")
    return figure
