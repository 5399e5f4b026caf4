"""Fig. 8: the contact moves by half a pitch to either side, along x, y or both; phi = 45 degrees."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from tfra.paper.picture import Columns, Picture, Text, legend_below, rounded, stacked
from tfra.paper.setups import Setup, near
from tfra.report.colours import BLACK, BLUE, VERMILION

PHI = 45
SHIFTS = tuple((x, y) for y in (-0.5, 0.0, 0.5) for x in (-0.5, 0.0, 0.5))
"""Displacements (x, y) in pitches."""

RANGES = {"hertz": ((0.50, 0.72), (36.61, 43.41)), "rectangle": ((0.52, 0.69), (28.81, 58.91))}
"""What the paper's Section 5.4 states: smallest and largest mu, smallest and largest phi in degrees."""


def fig8(setups: Sequence[Setup]) -> Picture:
    """mu and phi for nine places of both contacts."""
    parts = {setup.key: _columns(setup) for setup in setups}
    columns = stacked(parts)
    text = Text(
        " ".join(
            f"{s.title}: μ from {RANGES[s.key][0][0]:.2f} to {RANGES[s.key][0][1]:.2f}, "
            f"φ from {RANGES[s.key][1][0]:.2f}° to {RANGES[s.key][1][1]:.2f}°." for s in setups
        ),
        " ".join(f"{s.title}: {_range(parts[s.key])}." for s in setups),
        "A small footprint on large taxels changes its look with every half pitch. How much depends on its size, which "
        "is not published, so points outside the published range are no contradiction. Opposite displacements differ "
        "because the force has a direction.",
    )
    return Picture("fig8", f"Place of the contact, φ_ref = {PHI}°", columns, _draw(setups, parts), text)


def _columns(setup: Setup) -> Columns:
    sensor = setup.project.design.sensor
    contacts = [setup.contacts([PHI], shift)[0] for shift in SHIFTS]
    estimate = setup.tfra(setup.stress(contacts))
    dx, dy = np.array(SHIFTS).T
    columns: Columns = {
        "dx_mm": 1e3 * sensor.pitch_x * dx,
        "dy_mm": 1e3 * sensor.pitch_y * dy,
        "mu": estimate.mu,
        "phi_deg": near(estimate.phi_deg, np.full(len(SHIFTS), float(PHI))),
    }
    return rounded(columns)


def _range(columns: Columns) -> str:
    mu, phi = columns["mu"], columns["phi_deg"]
    return f"μ from {mu.min():.2f} to {mu.max():.2f}, φ from {phi.min():.2f}° to {phi.max():.2f}°"


def _signed(value: float) -> str:
    return f"{value:+g}".replace("-", "−") if value else "0"


def _draw(setups: Sequence[Setup], parts: dict[str, Columns]) -> Figure:
    figure = Figure(figsize=(9.5, 5.2), layout="constrained")
    axes = figure.subplots(2, len(setups), sharey="row")
    for column, (letter, setup) in enumerate(zip("ab", setups, strict=True)):
        data = parts[setup.key]
        labels = [f"{_signed(x)}\n{_signed(y)}" for x, y in zip(data["dx_mm"], data["dy_mm"], strict=True)]
        references = (setup.project.contacts[0].mu, PHI)
        for row, name in enumerate(("mu", "phi_deg")):
            panel = axes[row, column]
            panel.axhspan(*RANGES[setup.key][row], color=VERMILION, alpha=0.15, linewidth=0, label="published range")
            panel.axhline(references[row], color=BLACK, linestyle="--", linewidth=1, label="reference")
            panel.plot(range(len(labels)), data[name], "o", color=BLUE, label="TFRA, float")
            panel.set_xticks(range(len(labels)), labels)
        axes[0, column].set_title(f"({letter}) {setup.title}")
        axes[1, column].set_xlabel("displacement Δx, Δy / mm")
    axes[0, 0].set_ylabel(r"$\mu$")
    axes[1, 0].set_ylabel(r"$\varphi$ / °")
    legend_below(figure, axes[0, 0])
    return figure
