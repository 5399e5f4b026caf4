"""Tables 1 and 2 as published, and errors by Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tfra.model.metrics import error_force, error_mu, error_phi
from tfra.model.sensor import Floats

DATA = Path(__file__).parent / "data"

METHODS = {"tfra": "published TFRA", "ref7": "published two-variable [7]"}
"""Column ``method`` of the data, and how a reader sees it."""


@dataclass(frozen=True)
class Errors:
    """Largest errors in percent: forces (all three components), friction coefficient, direction."""

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


def errors(
    force_ref: npt.ArrayLike, force: npt.ArrayLike, mu_ref: npt.ArrayLike, mu: npt.ArrayLike,
    phi_ref_deg: npt.ArrayLike, phi_deg: npt.ArrayLike,
) -> Floats:  # fmt: skip
    """e(F_x), e(F_y), e(F_z), e(mu), e(phi) in percent (Eqs. 33-35), ``(n, 5)``.

    Forces are ``(n, 3)`` in N, the rest is ``(n,)``.
    """
    force = error_force(force_ref, force)
    single = np.stack(np.broadcast_arrays(error_mu(mu_ref, mu), error_phi(phi_ref_deg, phi_deg)), axis=-1)
    return np.concatenate([force, single], axis=-1)


def largest(percent: Floats) -> Errors:
    """The largest of ``errors`` ``(n, 5)``."""
    return Errors(*(float(percent[:, part].max()) for part in (slice(3), 3, 4)))


def errors_of(rows: list[dict[str, str]]) -> Floats:
    """``errors`` of published rows, ``(n, 5)``, from the printed, rounded numbers."""
    single = {key: [float(row[key]) for row in rows] for key in ("mu_fea", "mu_alg", "phi_ref", "phi_alg")}
    return errors([triple(row, "fea") for row in rows], [triple(row, "alg") for row in rows], *single.values())
