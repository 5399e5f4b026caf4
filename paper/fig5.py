"""Fig. 5: friction coefficient and direction while the tangential force turns once around."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tfra.model.arrays import Floats
from tfra.paper.picture import Columns, Picture, Text, legend_below, rounded, stacked
from tfra.paper.published import Contacts, errors, largest, table
from tfra.paper.setups import DIRECTIONS, Setup, near
from tfra.report.colours import BLACK, BLUE, ORANGE, VERMILION

STYLES: dict[str, dict[str, Any]] = {
    "TFRA, float": {"color": BLUE, "marker": "o", "linewidth": 1},
    "TFRA, bit-accurate": {"color": ORANGE, "marker": "x", "linewidth": 0},
    "published (Tables 1, 2)": {"color": VERMILION, "marker": "s", "linewidth": 0, "markerfacecolor": "none"},
}


def fig5(setups: Sequence[Setup]) -> Picture:
    """mu, phi and the error of phi over phi_ref, for both contacts."""
    parts = {setup.key: _columns(setup) for setup in setups}
    columns = stacked(parts)
    text = Text(
        "φ is off by at most 1.93 % (Hertzian) and 2.20 % (non-Hertzian) of a full turn; μ lies mostly above its "
        "reference for the Hertzian contact and around it for the other.",
        " ".join(_measured(setup) for setup in setups),
        "The paper publishes neither the size of its contacts nor its frames. With the sizes assumed here the largest "
        "errors stay below the published ones. These frames are an exact solution for a symmetric contact on an "
        "elastic layer: every quadrant repeats the first, and along an axis φ is exact. The published −1.81° at 0° and "
        "90.71° at 90° are not, so the paper's frames were not quite symmetric.",
    )
    return Picture("fig5", "Direction of the tangential force", columns, _draw(setups, parts), text)


def _columns(setup: Setup) -> Columns:
    reference = np.array(DIRECTIONS, dtype=float)
    stress = setup.stress(setup.contacts(DIRECTIONS))
    exact, fixed = (setup.engines[name](stress) for name in ("TFRA, float", "TFRA, bit-accurate"))
    columns: Columns = {
        "phi_ref_deg": np.array(DIRECTIONS),
        "mu_float": exact.mu,
        "mu_bit_accurate": fixed.mu,
        "phi_float_deg": near(exact.phi_deg, reference),
        "phi_bit_accurate_deg": near(fixed.phi_deg, reference),
    }
    return rounded(columns)


def _measured(setup: Setup) -> str:
    contacts = setup.contacts(DIRECTIONS)
    stress, forces, mu = setup.stress(contacts), np.array([c.force for c in contacts]), np.array(contacts[0].mu)
    reference = Contacts(forces, mu, np.array(DIRECTIONS))
    parts = []
    for name in ("TFRA, float", "TFRA, bit-accurate"):
        estimate = setup.engines[name](stress)
        worst = largest(errors(reference, Contacts(estimate.resultant, estimate.mu, estimate.phi_deg)))
        parts.append(
            f"{name}: φ {worst['phi_deg']:.2f}°, μ {worst['mu_abs']:.3f}, F {worst['force_n']:.2f} N (by the paper's "
            f"measures e(F) {worst['force']:.2f}, e(μ) {worst['mu']:.2f}, e(φ) {worst['phi']:.2f} %)"
        )
    return f"Largest errors of the {setup.title} in all {len(DIRECTIONS)} directions: {'; '.join(parts)}."


def _draw(setups: Sequence[Setup], parts: dict[str, Columns]) -> Figure:
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    axes = figure.subplots(3, len(setups), sharex=True, sharey="row")
    for column, (letter, setup) in enumerate(zip("ab", setups, strict=True)):
        top, middle, bottom = axes[:, column]
        top.set_title(f"({letter}) {setup.title}")
        _plot(setup, parts[setup.key], top, middle, bottom)
        bottom.set(xlabel=r"$\varphi_{ref}$ / °", xticks=range(0, 361, 45))
    for row, label in zip(axes, (r"$\mu$", r"$\varphi$ / °", r"$\varphi - \varphi_{ref}$ / °"), strict=True):
        row[0].set_ylabel(label)
    legend_below(figure, axes[0, 0])
    axes[1, 0].set_yticks(range(0, 361, 90))
    return figure


def _plot(setup: Setup, columns: Columns, top: Axes, middle: Axes, bottom: Axes) -> None:
    reference = columns["phi_ref_deg"]
    rows = [row for row in table(setup.data) if row["method"] == "tfra"]
    at, mu, phi = (np.array([float(row[key]) for row in rows]) for key in ("phi_ref", "mu_alg", "phi_alg"))
    curves: list[tuple[Floats, Floats, Floats]] = [
        (reference, columns["mu_float"], columns["phi_float_deg"]),
        (reference, columns["mu_bit_accurate"], columns["phi_bit_accurate_deg"]),
        (at, mu, phi),
    ]
    line: dict[str, Any] = {"color": BLACK, "linestyle": "--", "linewidth": 1, "label": "reference"}
    top.axhline(setup.project.contacts[0].mu, **line)
    middle.plot([0, 345], [0, 345], **line)
    bottom.axhline(0, **line)
    for (name, style), (x, friction, angle) in zip(STYLES.items(), curves, strict=True):
        top.plot(x, friction, label=name, **style)
        middle.plot(x, angle, label=name, **style)
        bottom.plot(x, angle - x, label=name, **style)
