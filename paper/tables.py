"""Tables 1 and 2: published numbers and this project's, errors by Eqs. 33-35 and in plain units, and the largest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import ContactShape
from tfra.model.tfra import Result
from tfra.paper.picture import Text
from tfra.paper.published import METHODS, PLAIN, Errors, errors, errors_of, largest, largest_plain, table
from tfra.paper.setups import TABLE_DIRECTIONS, Setup, near

HEADER = (
    "phi_ref_deg", "method",
    "Fx_ref_N", "Fx_N", "e_Fx_percent", "Fy_ref_N", "Fy_N", "e_Fy_percent", "Fz_ref_N", "Fz_N", "e_Fz_percent",
    "mu_ref", "mu", "e_mu_percent", "phi_deg", "e_phi_percent",
    "error_phi_deg", "error_mu_abs", "error_force_n", "error_force_percent_of_resultant",
)  # fmt: skip
"""Columns of a table; ``e_`` are the paper's measures (Eqs. 33-35), ``error_`` are in plain units (``PLAIN``)."""

MAXIMA_HEADER = ("method", "e_F_percent", "e_mu_percent", "e_phi_percent", *HEADER[-4:])
PUBLISHED = (
    "phi_ref", "Fx_fea", "Fx_alg", "Fy_fea", "Fy_alg", "Fz_fea", "Fz_alg", "mu_fea", "mu_alg", "phi_alg",
)  # fmt: skip

Cells = Sequence[Sequence[str]]

_PRESSURE = {
    ContactShape.HERTZ: "an elliptic Hertz pressure over",
    ContactShape.UNIFORM: "a uniform pressure over a rectangle of",
    ContactShape.ROUNDED: "a rounded pressure over a rectangle of",
}


@dataclass(frozen=True)
class Table:
    """Rows of text, as in the CSV files and on the page."""

    name: str
    title: str
    rows: Cells
    maxima: Cells
    largest: dict[str, Errors]
    """The numbers behind ``maxima``, not rounded, as the paper measures."""
    plain: dict[str, dict[str, float]]
    """The same in plain units, by the keys of ``PLAIN``, for all estimators with their own table."""
    text: Text


def make(name: str, setup: Setup) -> Table:
    """The table of one contact: for each direction what was published, then each engine."""
    contacts = setup.contacts(TABLE_DIRECTIONS)
    stress = setup.stress(contacts)
    forces, mu = np.array([c.force for c in contacts]), np.array([c.mu for c in contacts])
    parts, worst, plain = _published(setup)
    for engine, run in setup.engines.items():
        found = run(stress)
        phi = near(found.phi_deg, np.array(TABLE_DIRECTIONS, dtype=float))
        percent = errors(forces, found.resultant, mu, found.mu, TABLE_DIRECTIONS, phi)
        worst[engine], plain[engine] = largest(percent), largest_plain(percent)
        parts += _rows(engine, forces, mu, found, phi, percent)
    order = {str(phi): place for place, phi in enumerate(TABLE_DIRECTIONS)}
    rows = sorted(parts, key=lambda row: order[row[0]])
    maxima = [(method, *_percent(e), *_plain(plain.get(method))) for method, e in worst.items()]
    return Table(name, f"Forces, {setup.title}", rows, maxima, worst, plain, _text(setup, worst, plain))


def number(value: float, digits: int) -> str:
    """``value`` with that many decimals, never as minus zero."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"


def _percent(worst: Errors) -> list[str]:
    return [number(value, 2) for value in vars(worst).values()]


def _plain(values: dict[str, float] | None) -> list[str]:
    """Cells in the order of ``PLAIN``; without values, empty ones."""
    if values is None:
        return [""] * len(PLAIN)
    return [number(values[key], 3 if key == "mu_abs" else 2) for key in PLAIN]


def _published(setup: Setup) -> tuple[list[tuple[str, ...]], dict[str, Errors], dict[str, dict[str, float]]]:
    rows, worst, plain = [], {"printed in the paper's text": setup.printed}, {}
    for method, name in METHODS.items():
        mine = [row for row in table(setup.data) if row["method"] == method]
        percent = errors_of(mine)
        worst[f"{name}, recomputed"], plain[f"{name}, recomputed"] = largest(percent), largest_plain(percent)
        rows += [_row(name, [row[key] for key in PUBLISHED], e) for row, e in zip(mine, percent, strict=True)]
    return rows, worst, plain


def _rows(
    engine: str, forces: Floats, mu: Floats, found: Result, phi: Floats, percent: Floats
) -> list[tuple[str, ...]]:
    rows = []
    for n, direction in enumerate(TABLE_DIRECTIONS):
        pairs = np.stack([forces[n], found.resultant[n]], axis=1).ravel()
        values = [str(direction), *(number(f, 2) for f in pairs), number(mu[n], 2), number(found.mu[n], 3)]
        rows.append(_row(engine, [*values, number(phi[n], 2)], percent[n]))
    return rows


def _row(method: str, values: Sequence[str], percent: Floats) -> tuple[str, ...]:
    """Cells in the order of ``HEADER``; ``values`` in that of ``PUBLISHED``."""
    phi_ref, *pairs, phi = values
    e = [number(value, 2) for value in percent[:5]]
    quantities = [cell for n in range(4) for cell in (pairs[2 * n], pairs[2 * n + 1], e[n])]
    return phi_ref, method, *quantities, phi, e[4], *_plain(dict(zip(PLAIN, percent[5:], strict=True)))


def _text(setup: Setup, worst: dict[str, Errors], plain: dict[str, dict[str, float]]) -> Text:
    def said(method: str) -> str:
        e = worst[method]
        return f"{method}: e(F) {e.force:.2f} %, e(μ) {e.mu:.2f} %, e(φ) {e.phi:.2f} %."

    def plainly(method: str) -> str:
        phi, mu, newtons, percent = _plain(plain[method])
        return f"{method}: φ {phi}°, μ {mu}, F {newtons} N or {percent} % of |F|."

    contact, sensor = setup.project.contacts[0], setup.project.design.sensor
    size = f"{2e3 * contact.half_x:g} mm × {2e3 * contact.half_y:g} mm"
    return Text(
        f"The text states largest errors of {setup.printed.force:.2f} % (forces), {setup.printed.mu:.2f} % (μ) and "
        f"{setup.printed.phi:.2f} % (φ), by its Eqs. 33–35. Recomputed from the printed, rounded numbers, they are "
        f"{said('published TFRA, recomputed').partition(': ')[2]} {_note(setup, worst)}",
        "Largest errors by the paper's measures, "
        + " ".join(said(method) for method in setup.engines)
        + " In plain units, the largest are: "
        + " ".join(plainly(method) for method in setup.engines),
        f"The contact itself is not published beyond its kind. Here it is {_PRESSURE[contact.shape]} {size} with "
        f"F_z = {contact.normal_force:g} N and μ = {contact.mu:g}, on {sensor.rows} × {sensor.columns} taxels of "
        f"{1e3 * sensor.pitch_x:g} mm × {1e3 * sensor.pitch_y:g} mm; stress is an exact solution of the elastic layer "
        "instead of finite elements. So agreement can't be digit by digit. The bit-accurate model sees converter codes "
        "instead of exact stress. The two-variable method is this project's reading of the paper's description of its "
        "reference [7]; the functionals are not printed there, so these errors say nothing about the original.",
    )


def _note(setup: Setup, worst: dict[str, Errors]) -> str:
    """A sentence where the paper's text and its own table differ by more than rounding."""
    column = worst["published TFRA, recomputed"].force
    if column <= setup.printed.force + 0.25:
        return ""
    return f"So the {setup.printed.force:.2f} % of the text leaves out a larger error in its own table."
