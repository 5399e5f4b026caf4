"""Errors of an estimate, in plain units and by Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070; Eqs. 36, 37."""

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats, Ints

ERRORS = {
    "phi_deg": "φ / °",
    "mu_abs": "μ, absolute",
    "force_n": "F / N",
    "force_percent_of_resultant": "F / % of |F|",
    "paper_phi_percent_of_turn": "paper's e(φ), % of a full turn, Eq. 34",
    "paper_mu_percent_of_one": "paper's e(μ), % of μ = 1, Eq. 33",
    "paper_force_percent_of_estimate": "paper's e(F), % of the |F| found, Eq. 35",
}
"""Keys of :func:`errors`, with the unit in each, and their headings for readers."""


class Contact(Protocol):
    """True or estimated quantities of contacts: ``resultant (n, 3)`` in N, ``mu (n,)`` and ``phi_deg (n,)``."""

    @property
    def resultant(self) -> Floats: ...

    @property
    def mu(self) -> Floats: ...

    @property
    def phi_deg(self) -> Floats: ...


class Some(NamedTuple):
    """The quantities of some contacts."""

    resultant: Floats
    mu: Floats
    phi_deg: Floats

    @classmethod
    def of(cls, every: Contact, which: Ints) -> "Some":
        """Those of the contacts ``which (k,)``."""
        return cls(every.resultant[which], every.mu[which], every.phi_deg[which])


def errors(reference: Contact, estimate: Contact) -> dict[str, Floats]:
    """Return every error of ``estimate`` by the keys of ``ERRORS``, each ``(n,)``.

    F is the length of the difference of both resultants, |F| the length of the reference's; the paper's e(F) is its
    worst component.
    """
    force, modulus = (
        np.linalg.norm(vector, axis=-1) for vector in (estimate.resultant - reference.resultant, reference.resultant)
    )
    undefined = np.where(force > 0.0, np.inf, 0.0)
    turn, friction = turn_deg(reference.phi_deg, estimate.phi_deg), np.abs(reference.mu - estimate.mu)
    return {
        "phi_deg": turn,
        "mu_abs": friction,
        "force_n": force,
        "force_percent_of_resultant": 100.0 * np.divide(force, modulus, out=undefined, where=modulus > 0.0),
        "paper_phi_percent_of_turn": turn / 3.6,
        "paper_mu_percent_of_one": 100.0 * friction,
        "paper_force_percent_of_estimate": error_force(reference.resultant, estimate.resultant).max(axis=-1),
    }


def turn_deg(reference_deg: npt.ArrayLike, estimate_deg: npt.ArrayLike) -> Floats:
    """Return the angle between two directions in degrees, 0 to 180 (Eq. 34 does not wrap); the arguments broadcast."""
    return np.abs(rotation_deg(estimate_deg, reference_deg))


def rotation_deg(start_deg: npt.ArrayLike, end_deg: npt.ArrayLike) -> Floats:
    """Return the rotation that leads from one direction to the other in degrees, -180 to below 180."""
    difference = np.subtract(end_deg, start_deg, dtype=np.float64)
    return np.asarray(np.remainder(difference + 180.0, 360.0) - 180.0)


def error_force(reference: npt.ArrayLike, estimate: npt.ArrayLike) -> Floats:
    """Return e(F_x), e(F_y), e(F_z) of Eq. 35 in percent of F_T, the modulus of the estimated resultant.

    Both arguments have shape ``(..., 3)`` in newtons and broadcast; so does the result.  Where F_T is zero, a
    component that differs from its reference has error inf and one that agrees has error 0.
    """
    expected, estimated = np.asarray(reference, dtype=np.float64), np.asarray(estimate, dtype=np.float64)
    difference = np.abs(expected - estimated)
    modulus = np.broadcast_to(np.linalg.norm(estimated, axis=-1, keepdims=True), difference.shape)
    undefined = np.where(difference > 0.0, np.inf, 0.0)
    return np.asarray(100.0 * np.divide(difference, modulus, out=undefined, where=modulus > 0.0))
