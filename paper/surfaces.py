"""Figs. 6 and 7: stress on the cover as loaded and as reconstructed (Eqs. 36, 37)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray
from tfra.paper.picture import STRESS_MAP, Columns, Picture, Text, rounded
from tfra.paper.setups import Setup

DIRECTIONS = (0, 30, 60, 90)

FINE = 40
"""The load is averaged over a taxel's cell from this many points along each side."""

PANELS = {
    "q_t_ref_kPa": r"$q_{t,ref}$",
    "q_t_kPa": "$q_t$ by TFRA",
    "q_z_ref_kPa": r"$q_{z,ref}$",
    "q_z_kPa": "$q_z$ by TFRA",
}


def surfaces(name: str, setup: Setup) -> Picture:
    """q_t and q_z in four directions, reference beside reconstruction."""
    contacts = setup.contacts(DIRECTIONS)
    sensor = setup.project.design.sensor
    load = np.array([cell_means(sensor, contact) for contact in contacts])
    estimate = setup.tfra(setup.stress(contacts)).forces / sensor.taxel_area  # Eq. 37
    columns = _columns(sensor, load, estimate)
    text = Text(
        "Four directions of surfaces, similar to the reference in each; no numbers.",
        _measured(columns),
        "The reference is the load itself, averaged over the cell of each taxel, so that both surfaces have one grid "
        "and one colour scale. TFRA knows one number per taxel and takes the cover for a half-space, while it is a "
        "thin layer on a rigid base: peaks differ in height, the side that the force points to is loaded more, and "
        "normal traction appears around the contact. TFRA demands compression at the base (Eq. 23), not on the cover.",
    )
    title = f"Stress on the cover, {setup.title}"
    return Picture(name, title, columns, _draw(setup, columns), text)


def cell_means(sensor: SensorArray, contact: Contact) -> Floats:
    """q_x, q_y, q_z of Eq. 32 averaged over each taxel's cell, ``(3, rows, columns)``, Pa."""
    inner = (np.arange(FINE) + 0.5) / FINE - 0.5
    x = (np.arange(sensor.columns)[:, None] + inner).ravel() * sensor.pitch_x
    y = (np.arange(sensor.rows)[:, None] + inner).ravel() * sensor.pitch_y
    values = contact.tractions(x[None, :], y[:, None])
    return np.asarray(values.reshape(3, sensor.rows, FINE, sensor.columns, FINE).mean(axis=(2, 4)))


def _columns(sensor: SensorArray, load: Floats, estimate: Floats) -> Columns:
    x, y = sensor.positions()
    columns: Columns = {
        "phi_ref_deg": np.repeat(DIRECTIONS, sensor.taxels),
        "x_mm": np.tile(1e3 * x, len(DIRECTIONS)),
        "y_mm": np.tile(1e3 * y, len(DIRECTIONS)),
    }
    for suffix, (q_x, q_y, q_z) in (("_ref", np.moveaxis(load, 1, 0)), ("", np.moveaxis(estimate, 1, 0))):
        columns[f"q_t{suffix}_kPa"] = 1e-3 * np.hypot(q_x, q_y).ravel()  # Eq. 36
        columns[f"q_z{suffix}_kPa"] = 1e-3 * q_z.ravel()
    return rounded(columns)


def _measured(columns: Columns) -> str:
    q_t, q_z = columns["q_t_kPa"], columns["q_z_kPa"]
    t_ref, z_ref = columns["q_t_ref_kPa"], columns["q_z_ref_kPa"]
    rms_t, rms_z = (float(np.sqrt(np.mean((a - b) ** 2))) for a, b in ((q_t, t_ref), (q_z, z_ref)))
    return (
        f"Peak of q_t over all directions: {t_ref.max():.1f} kPa loaded, {q_t.max():.1f} kPa reconstructed; of q_z: "
        f"{z_ref.min():.1f} and {q_z.min():.1f} kPa, with traction up to {q_z.max():.1f} kPa "
        f"reconstructed. Root mean square difference over all taxels and directions: "
        f"{rms_t:.2f} kPa in q_t, {rms_z:.2f} kPa in q_z."
    )


def _draw(setup: Setup, columns: Columns) -> Figure:
    sensor = setup.project.design.sensor
    shape = (len(DIRECTIONS), sensor.rows, sensor.columns)
    height = 1.9 if sensor.size_y == sensor.size_x else 1.3
    figure = Figure(figsize=(9.5, height * len(DIRECTIONS) + 1.2))
    figure.set_layout_engine("constrained", h_pad=0.08)
    axes = figure.subplots(len(DIRECTIONS), len(PANELS), sharex=True, sharey=True)
    for first in (0, 2):
        names = list(PANELS)[first : first + 2]
        most = max(np.abs(columns[name]).max() for name in names)
        colors = {"cmap": STRESS_MAP, "vmin": -most} if "q_z_kPa" in names else {"cmap": "Greens", "vmin": 0}
        for column, name in enumerate(names, first):
            for row, values in enumerate(columns[name].reshape(shape)):
                image = _panel(axes[row, column], sensor, values, {**colors, "vmax": most})
            axes[0, column].set_title(PANELS[name])
            axes[-1, column].set_xlabel("x / mm")
        label = f"${names[1].removesuffix('_kPa')}$ / kPa"
        figure.colorbar(image, ax=axes[:, first : first + 2], label=label, location="bottom", shrink=0.7, aspect=40)
    for row, phi in enumerate(DIRECTIONS):
        axes[row, 0].set_ylabel(rf"$\varphi_{{ref}}$ = {phi}°" + "\ny / mm")
    return figure


def _panel(axes: Axes, sensor: SensorArray, values: Floats, colors: dict[str, Any]) -> QuadMesh:
    """One map; white is no stress."""
    x, y = np.arange(sensor.columns) * 1e3 * sensor.pitch_x, np.arange(sensor.rows) * 1e3 * sensor.pitch_y
    axes.set_aspect("equal")
    axes.grid(False)
    return axes.pcolormesh(x, y, values, rasterized=True, **colors)
