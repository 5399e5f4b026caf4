"""Fig. 2: normal stress under a Hertz contact, and the centroids of compression and traction (Eqs. 19-22)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from tfra.model.arrays import Floats
from tfra.paper.picture import Columns, Picture, Text, rounded
from tfra.paper.setups import Setup
from tfra.report.colours import BLACK, BLUE, VERMILION

PHI = 45
"""Direction of the tangential force, in degrees; the paper does not say its own."""


def fig2(setup: Setup) -> Picture:
    """The stress surface and its map with both centroids."""
    stress = setup.stress(setup.contacts([PHI]))[0]
    x, y = setup.project.design.sensor.positions()
    compression, traction = (_centroid(part, x, y) for part in (np.minimum(stress, 0), np.maximum(stress, 0)))
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
    return Picture("fig2", title, columns, _draw(setup, columns, compression, traction), text)


def _centroid(part: Floats, x: Floats, y: Floats) -> Floats:
    return np.asarray([part.ravel() @ x, part.ravel() @ y], dtype=np.float64) / float(part.sum())


def _draw(setup: Setup, columns: Columns, compression: Floats, traction: Floats) -> Figure:
    sensor = setup.project.design.sensor
    x, y, stress = (c.reshape(sensor.rows, sensor.columns) for c in columns.values())
    norm = TwoSlopeNorm(0, stress.min(), stress.max())
    figure = Figure(figsize=(9.5, 4.0), layout="constrained")
    surface = figure.add_subplot(1, 2, 1, projection="3d")
    surface.plot_surface(x, y, stress, cmap="PuOr", norm=norm, edgecolor=BLACK, linewidth=0.3)
    surface.set(xlabel="x / mm", ylabel="y / mm", zlabel="$b_z$ / kPa", xticks=range(0, 40, 10), yticks=range(0, 20, 5))
    surface.view_init(elev=28, azim=-60)
    surface.set_box_aspect((1.6, 1.2, 1.0), zoom=1.1)
    flat = figure.add_subplot(1, 2, 2)
    image = flat.pcolormesh(x, y, stress, cmap="PuOr", norm=norm, rasterized=True)
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
    axes.plot(*traction, "s", color=BLUE, markeredgecolor="white", markersize=8, label="traction centroid")
    axes.plot(*compression, "o", color=VERMILION, markeredgecolor="white", markersize=8, label="compression centroid")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02), ncols=2)
