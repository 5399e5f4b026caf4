"""The two-variable search of the paper's reference [7], in this project's reading.

doi:10.1016/j.mechatronics.2023.103070, Section 2: mu_x and mu_y of Eq. 10 maximise Pi = Pi1 Pi2 Pi3 over [-1, 1]^2.
The paper states the condition and the variables of each functional, not its formula; docs/studies/two_variable.md
derives the formulas used here.  Each is Pi = 1 / (1 + |r|^2) with a residual r that is affine in u = (1, mu_x, mu_y).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import optimize

from tfra.model.arrays import Bools, Floats
from tfra.model.boussinesq import operators
from tfra.model.choices import Choices
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, check_frames, direction_deg, friction, in_contact, unit_scaled

GRID = 21
"""Points along each axis of the first grid; its best peaks are refined."""

PEAKS = 4
"""Peaks of the grid that are refined."""

_CLIMB = {
    "method": "L-BFGS-B",
    "jac": True,
    "bounds": [(-1.0, 1.0), (-1.0, 1.0)],
    "options": {"ftol": 1e-15, "gtol": 1e-10},
}


@dataclass(frozen=True)
class Conditions:
    """The three conditions on one frame of m taxels: residuals ``u @ matrix`` without unit, u = (1, mu_x, mu_y).

    ``normal (3, m)``: f_z, of which only traction counts; ``similar (3, 2 m)``: f_x - mu_x |w_z| and f_y - mu_y |w_z|;
    ``pinch (3, 2)``: the moments sum f_x d1 and sum f_y d2 about the centre of w_z.
    """

    normal: Floats
    similar: Floats
    pinch: Floats

    @classmethod
    def of(cls, sensor: SensorArray, a: Floats, n: Floats) -> "Conditions":
        """From a_pq of Eq. 10, ``(3, 3, m)`` as force p, power q, taxel, and n = -w_z >= 0, ``(m,)``, both in N.

        A frame with n = 0 has residuals of zero.
        """
        total, norm = n.sum(), np.linalg.norm(n)
        if total == 0:
            return cls(np.zeros_like(a[2]), np.zeros((3, 2 * len(n))), np.zeros((3, 2)))
        x, y = sensor.positions()
        d1, d2 = x - x @ n / total, y - y @ n / total
        cell = (sensor.pitch_x**2 + sensor.pitch_y**2) / 12  # a taxel's force is spread over its cell
        lever = np.sqrt((d1**2 + d2**2) @ n / total + cell)
        similar = a[:2].copy()
        similar[0, 1] -= n
        similar[1, 2] -= n
        pinch = np.stack([a[0] @ d1, a[1] @ d2], axis=1)
        return cls(a[2] / norm, np.hstack(list(similar)) / norm, pinch / (total * lever))

    def functionals(self, mu_x: npt.ArrayLike, mu_y: npt.ArrayLike) -> Floats:
        """Pi1, Pi2, Pi3, each in (0, 1], in an array ``(3, ...)``; ``mu_x`` and ``mu_y`` broadcast."""
        mu_x, mu_y = np.broadcast_arrays(mu_x, mu_y)
        residuals = self._residuals(np.stack([np.ones(mu_x.shape), mu_x, mu_y], axis=-1))
        return 1.0 / (1.0 + np.stack([(r * r).sum(axis=-1) for r in residuals]))

    def _residuals(self, u: Floats) -> tuple[Floats, Floats, Floats]:
        return np.maximum(u @ self.normal, 0.0), u @ self.similar, u @ self.pinch

    def loss(self, mu: Floats) -> tuple[float, Floats]:
        """-log Pi at ``mu = (mu_x, mu_y)`` and its gradient ``(2,)``."""
        value, gradient, residuals = 0.0, np.zeros(3), self._residuals(np.array([1.0, *mu]))
        for matrix, r in zip((self.normal, self.similar, self.pinch), residuals, strict=True):
            value += float(np.log1p(r @ r))
            gradient += 2.0 / (1.0 + r @ r) * (matrix @ r)
        return value, gradient[1:]

    def best(self) -> Floats:
        """(mu_x, mu_y) of the largest Pi, ``(2,)``: the best peaks of a grid, each climbed by L-BFGS-B.

        Deterministic; of equal optima the first one found.
        """
        climbed = [optimize.minimize(self.loss, start, **_CLIMB) for start in self._peaks()]
        return np.asarray(min(climbed, key=lambda end: end.fun).x, dtype=np.float64)

    def _peaks(self) -> Floats:
        """Up to ``PEAKS`` points of the grid, ``(k, 2)``, where no neighbour has a larger Pi, best first."""
        axis = np.linspace(-1.0, 1.0, GRID)
        product = self.functionals(axis[:, None], axis[None, :]).prod(axis=0)
        around = np.lib.stride_tricks.sliding_window_view(np.pad(product, 1), (3, 3)).max(axis=(2, 3))
        i, j = np.nonzero(product >= around)
        order = np.argsort(-product[i, j], kind="stable")[:PEAKS]
        return np.stack([axis[i[order]], axis[j[order]]], axis=1)


class TwoVariable:
    """The two-variable search for one sensor; frames without contact or traction are treated as in ``Tfra``.

    ``contact_threshold`` in Pa is ``Tfra``'s, too.
    ``mu_x`` and ``mu_y`` are the optimum and ``phi_deg`` the direction of the resultant, 0 with ``NO_DIRECTION`` where
    its tangential part vanishes.  There is no sweep: ``sweep_index`` is -1.
    """

    def __init__(self, sensor: SensorArray, contact_threshold: float = 0.0) -> None:
        self.sensor = sensor
        self.contact_threshold = contact_threshold
        self._ops = operators(sensor)

    @classmethod
    def of(cls, choices: Choices) -> "TwoVariable":
        """The search with the contact threshold of ``design``."""
        return cls(choices.sensor, choices.adc.threshold * choices.adc.lsb)

    def __call__(self, frames: npt.ArrayLike) -> Result:
        """Forces of ``frames (n, rows, columns)`` in Pa; raises ``ValueError`` for a wrong shape or NaN."""
        b = check_frames(self.sensor, frames).reshape(-1, self.sensor.taxels)
        contact, traction = in_contact(b, self.contact_threshold), np.asarray((b > 0).any(axis=1))
        regular = contact & traction
        mu, forces = np.zeros((len(b), 2)), np.zeros((len(b), 3, self.sensor.taxels))
        unit, exponents = unit_scaled(b)
        for i in np.flatnonzero(regular):
            a, n = self.coefficients(unit[i])
            mu[i] = Conditions.of(self.sensor, a, n).best()
            found = a[:, 0] + mu[i, 0] * a[:, 1] + mu[i, 1] * a[:, 2]  # Eq. 10
            f_sens, f_star = np.abs(unit[i]).sum() * self.sensor.taxel_area, np.linalg.norm(found.sum(axis=1))
            forces[i] = np.ldexp(found * (f_sens / f_star if f_star > 0 else 0.0), exponents[i])  # Eqs. 29-31
        pressed = contact & ~traction
        forces[pressed, 2] = b[pressed] @ self._ops.c33_inv.T
        return self._result(forces, mu, contact, regular)

    def coefficients(self, b: Floats) -> tuple[Floats, Floats]:
        """a_pq of Eq. 10 as force p, power q, taxel, ``(3, 3, m)``, and n = -w_z of Eq. 9, ``(m,)``; all in N."""
        ops = self._ops
        n = np.maximum(-(ops.c33_inv @ b), 0.0)
        d = np.stack([b + ops.c33 @ n, -ops.c31 @ n, -ops.c32 @ n])
        a = np.stack([d @ pinv.T for pinv in (ops.pinv1, ops.pinv2, ops.pinv3)])
        a[0, 1] += n
        a[1, 2] += n
        a[2, 0] -= n
        return a, n

    def _result(self, forces: Floats, mu: Floats, contact: Bools, regular: Bools) -> Result:
        """Resultant (Eq. 12), friction (Eq. 15), direction (Eq. 16) and status of ``forces (n, 3, m)``."""
        resultant = forces.sum(axis=2)
        phi, still = direction_deg(resultant)
        status = (
            np.where(contact, 0, Status.NO_CONTACT)
            | np.where(contact & ~regular, Status.COMPRESSION_ONLY, 0)
            | np.where(regular & still, Status.NO_DIRECTION, 0)
        ).astype(np.int64)
        shape = (len(forces), 3, self.sensor.rows, self.sensor.columns)
        index = np.full(len(forces), -1, dtype=np.int64)
        return Result(forces.reshape(shape), resultant, phi, friction(resultant), mu[:, 0], mu[:, 1], index, status)
