"""Tables 1 and 2: published numbers and this project's, errors by Eqs. 33-35 and in plain units, and the largest."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import ContactShape
from tfra.paper.picture import Text
from tfra.paper.published import (
    METHODS,
    PAPER,
    PLAIN,
    Contacts,
    errors,
    errors_of,
    largest,
    number,
    percents,
    plain,
    table,
)
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
    largest: dict[str, dict[str, float]]
    """The numbers behind ``maxima``, not rounded: by the keys of ``PAPER``, and of ``PLAIN`` where there is a table."""
    text: Text


def build(name: str, setup: Setup) -> Table:
    """The table of one contact: for each direction what was published, then each engine."""
    contacts = setup.contacts(TABLE_DIRECTIONS)
    stress = setup.stress(contacts)
    forces, mu = np.array([c.force for c in contacts]), np.array([c.mu for c in contacts])
    parts, worst = _published(setup)
    reference = Contacts(forces, mu, np.array(TABLE_DIRECTIONS, dtype=float))
    for engine, run in setup.engines.items():
        result = run(stress)
        estimate = Contacts(result.resultant, result.mu, near(result.phi_deg, reference.phi_deg))
        every = errors(reference, estimate)
        worst[engine] = largest(every)
        parts += _rows(engine, reference, estimate, every)
    order = {str(phi): place for place, phi in enumerate(TABLE_DIRECTIONS)}
    rows = sorted(parts, key=lambda row: order[row[0]])
    maxima = [(method, *percents(e), *plain(e)) for method, e in worst.items()]
    return Table(name, f"Forces, {setup.title}", rows, maxima, worst, _text(setup, worst))


def _published(setup: Setup) -> tuple[list[tuple[str, ...]], dict[str, dict[str, float]]]:
    rows, worst = [], {"printed in the paper's text": setup.printed}
    for method, name in METHODS.items():
        mine = [row for row in table(setup.data) if row["method"] == method]
        every = errors_of(mine)
        worst[f"{name}, recomputed"] = largest(every)
        rows += [_row(name, [row[key] for key in PUBLISHED], every, n) for n, row in enumerate(mine)]
    return rows, worst


def _rows(engine: str, reference: Contacts, estimate: Contacts, every: dict[str, Floats]) -> list[tuple[str, ...]]:
    rows = []
    for n, direction in enumerate(TABLE_DIRECTIONS):
        pairs = np.stack([reference.resultant[n], estimate.resultant[n]], axis=1).ravel()
        mu = number(reference.mu[n], 2), number(estimate.mu[n], 3)
        values = [str(direction), *(number(f, 2) for f in pairs), *mu, number(estimate.phi_deg[n], 2)]
        rows.append(_row(engine, values, every, n))
    return rows


def _row(method: str, values: Sequence[str], every: dict[str, Floats], n: int) -> tuple[str, ...]:
    """Cells in the order of ``HEADER``: ``values`` in that of ``PUBLISHED`` with the errors of row ``n``."""
    phi_ref, *pairs, phi = values
    own = {key: float(every[key][n]) for key in (*PAPER, *PLAIN)}
    e = [number(value, 2) for value in (*every["axes"][n], own["mu"])]
    quantities = [cell for n, error in enumerate(e) for cell in (pairs[2 * n], pairs[2 * n + 1], error)]
    return phi_ref, method, *quantities, phi, number(own["phi"], 2), *plain(own)


def _text(setup: Setup, worst: dict[str, dict[str, float]]) -> Text:
    def by_paper(method: str) -> str:
        force, mu, phi = percents(worst[method])
        return f"{method}: e(F) {force} %, e(μ) {mu} %, e(φ) {phi} %."

    def plainly(method: str) -> str:
        phi, mu, newtons, percent = plain(worst[method])
        return f"{method}: φ {phi}°, μ {mu}, F {newtons} N or {percent} % of |F|."

    contact, sensor = setup.project.contacts[0], setup.project.design.sensor
    size = f"{2e3 * contact.half_x:g} mm × {2e3 * contact.half_y:g} mm"
    return Text(
        "The text states largest errors of {} % (forces), {} % (μ) and {} % (φ), by its Eqs. 33–35. Recomputed from "
        "the printed, rounded numbers, they are ".format(*percents(setup.printed))
        + f"{by_paper('published TFRA, recomputed').partition(': ')[2]} {_note(setup, worst)}",
        "Largest errors by the paper's measures, "
        + " ".join(by_paper(method) for method in setup.engines)
        + " In plain units, the largest are: "
        + " ".join(plainly(method) for method in setup.engines),
        f"The contact itself is not published beyond its kind. Here it is {_PRESSURE[contact.shape]} {size} with "
        f"F_z = {contact.normal_force:g} N and μ = {contact.mu:g}, on {sensor.rows} × {sensor.columns} taxels of "
        f"{1e3 * sensor.pitch_x:g} mm × {1e3 * sensor.pitch_y:g} mm; stress is an exact solution of the elastic layer "
        "instead of finite elements. So agreement can't be digit by digit. The bit-accurate model sees converter codes "
        "instead of exact stress. The two-variable method is this project's reading of the paper's description of its "
        "reference [7]; the functionals are not printed there, so these errors say nothing about the original.",
    )


def _note(setup: Setup, worst: dict[str, dict[str, float]]) -> str:
    """A sentence where the paper's text and its own table differ by more than rounding."""
    stated = setup.printed["force"]
    if worst["published TFRA, recomputed"]["force"] <= stated + 0.25:
        return ""
    return f"So the {stated:.2f} % of the text leaves out a larger error in its own table."
