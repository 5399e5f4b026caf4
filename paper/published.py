"""Tables 1 and 2 as published, and errors by Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tfra.model import metrics
from tfra.model.arrays import Floats

DATA = Path(__file__).parent / "data"

METHODS = {"tfra": "published TFRA", "ref7": "published two-variable [7]"}
"""Column ``method`` of the data, and its label for readers."""

PAPER = {
    "force": "paper_force_percent_of_estimate",
    "mu": "paper_mu_percent_of_one",
    "phi": "paper_phi_percent_of_turn",
}
"""Errors as the paper measures them, in percent (Eqs. 35, 33, 34), and their keys in ``metrics.ERRORS``."""

PRINTED = {
    "hertz_40x20": {"force": 10.93, "mu": 9.41, "phi": 1.64},
    "rectangle_40x40": {"force": 5.44, "mu": 4.46, "phi": 3.16},
}
"""Largest errors that the paper's text states for its Tables 1 and 2, by example and by the keys of ``PAPER``."""

PLAIN = ("phi_deg", "mu_abs", "force_n", "force_percent_of_resultant")
"""Errors in plain units, keys of ``metrics.ERRORS``: degrees, absolute, length of F's error in N and in % of |F|."""


@dataclass(frozen=True)
class Contacts:
    """True or estimated quantities: forces ``(n, 3)`` in N, friction and direction in degrees ``(n,)``."""

    resultant: Floats
    mu: Floats
    phi_deg: Floats


def table(name: str) -> list[dict[str, str]]:
    """The rows of data file ``name``, cells as printed: no number is parsed."""
    with open(DATA / name, encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def errors(reference: metrics.Contact, estimate: metrics.Contact) -> dict[str, Floats]:
    """Errors by the keys of ``PAPER`` and of ``PLAIN``, each ``(n,)``, and of each component as ``axes (n, 3)``."""
    every = metrics.errors(reference, estimate)
    ours = {key: every[name] for key, name in PAPER.items()} | {key: every[key] for key in PLAIN}
    return ours | {"axes": metrics.error_force(reference.resultant, estimate.resultant)}


def largest(every: dict[str, Floats]) -> dict[str, float]:
    """The largest of :func:`errors`, by the keys of ``PAPER`` and of ``PLAIN``."""
    return {key: float(every[key].max()) for key in (*PAPER, *PLAIN)}


def number(value: float, digits: int) -> str:
    """``value`` with that many decimals, never as minus zero."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"


def percents(worst: dict[str, float]) -> list[str]:
    """Cells in the order of ``PAPER``."""
    return [number(worst[key], 2) for key in PAPER]


def plain(values: dict[str, float]) -> list[str]:
    """Cells in the order of ``PLAIN``; empty ones without values."""
    return [number(values[key], 3 if key == "mu_abs" else 2) if key in values else "" for key in PLAIN]


def errors_of(rows: list[dict[str, str]]) -> dict[str, Floats]:
    """:func:`errors` of published rows, from the printed, rounded numbers."""

    def column(name: str) -> Floats:
        return np.array([float(row[name]) for row in rows])

    def contacts(kind: str, phi: str) -> Contacts:
        forces = np.stack([column(f"F{axis}_{kind}") for axis in "xyz"], axis=1)
        return Contacts(forces, column(f"mu_{kind}"), column(phi))

    return errors(contacts("fea", "phi_ref"), contacts("alg", "phi_alg"))
