"""Tables 1 and 2 as published, and errors by Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tfra.model import metrics
from tfra.model.arrays import Floats

DATA = Path(__file__).parent / "data"

METHODS = {"tfra": "published TFRA", "ref7": "published two-variable [7]"}
"""Column ``method`` of the data, and its label for readers."""


PLAIN = ("phi_deg", "mu_abs", "force_n", "force_percent_of_resultant")
"""Errors in plain units, keys of ``metrics.ERRORS``: degrees, absolute, length of F's error in N and in % of |F|."""


@dataclass(frozen=True)
class Errors:
    """Largest errors in percent as the paper measures: forces (all components), friction coefficient, direction."""

    force: float
    mu: float
    phi: float


def table(name: str) -> list[dict[str, str]]:
    """The rows of data file ``name``, cells as printed: no number is parsed."""
    with open(DATA / name, encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def triple(row: dict[str, str], kind: str) -> list[float]:
    """F_x, F_y, F_z in N of a row; ``kind`` is ``"fea"`` for the reference or ``"alg"`` for the estimate."""
    return [float(row[f"F{axis}_{kind}"]) for axis in "xyz"]


@dataclass(frozen=True)
class _Contact:
    resultant: Floats
    mu: Floats
    phi_deg: Floats


def errors(
    force_ref: npt.ArrayLike, force: npt.ArrayLike, mu_ref: npt.ArrayLike, mu: npt.ArrayLike,
    phi_ref_deg: npt.ArrayLike, phi_deg: npt.ArrayLike,
) -> Floats:  # fmt: skip
    """e(F_x), e(F_y), e(F_z), e(mu), e(phi) in percent (Eqs. 33-35), then the errors of ``PLAIN``: ``(n, 9)``.

    Forces are ``(n, 3)`` in N, the rest is ``(n,)``.
    """
    reference, found = (
        _Contact(*(np.asarray(value, dtype=np.float64) for value in values))
        for values in ((force_ref, mu_ref, phi_ref_deg), (force, mu, phi_deg))
    )
    every = metrics.errors(reference, found)
    single = np.stack([every[key] for key in ("paper_mu_percent_of_one", "paper_phi_percent_of_turn", *PLAIN)], axis=-1)
    return np.concatenate([metrics.error_force(force_ref, force), single], axis=-1)


def largest(percent: Floats) -> Errors:
    """The largest of ``errors`` ``(n, 9)`` by the paper's measures."""
    return Errors(*(float(percent[:, part].max()) for part in (slice(3), 3, 4)))


def largest_plain(percent: Floats) -> dict[str, float]:
    """The largest of ``errors`` ``(n, 9)`` in plain units, by the keys of ``PLAIN``."""
    return dict(zip(PLAIN, percent[:, 5:].max(axis=0).tolist(), strict=True))


def errors_of(rows: list[dict[str, str]]) -> Floats:
    """``errors`` of published rows, ``(n, 9)``, from the printed, rounded numbers."""
    single = {key: [float(row[key]) for row in rows] for key in ("mu_fea", "mu_alg", "phi_ref", "phi_alg")}
    return errors([triple(row, "fea") for row in rows], [triple(row, "alg") for row in rows], *single.values())
