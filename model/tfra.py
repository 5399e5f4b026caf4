"""Floating-point TFRA, Eqs. 7-31 of doi:10.1016/j.mechatronics.2023.103070, for batches of frames.

Every candidate of Eq. 7 reproduces the measured stress exactly (A f = b).  With w_z = -n (n >= 0) and the
residuals d0 = b + C33 n, d1 = -C31 n, d2 = -C32 n, Eq. 10 reads f = w + A-dagger (d0 + mu_x d1 + mu_y d2).
The dependent friction is affine in the independent one (Eqs. 17, 18), so the residual becomes e0 + mu e1 and
the normal part of the stress C33 f_z = p + mu q: p and q once per frame, then one addition per candidate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import IntFlag
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.boussinesq import Operators, operators
from tfra.model.choices import Choices
from tfra.model.sensor import SensorArray

COEFFICIENT_LIMIT = 2.0
"""Eqs. 17/18: a coefficient of the dependent friction at or over this means a vanishing denominator."""

TIE = 1e-12
"""Rounding noise: |cos| and |sin| closer than this (relative) count as equal, and |mu| <= 1 holds within it."""

STILL = 1e-6
"""A tangential resultant below this share of the normal one is rounding error and has no direction."""

_CHUNK_BYTES = 4 << 20


class Status(IntFlag):
    """Special cases of a frame; every flagged frame still has a defined result."""

    NO_CONTACT = 1
    """No taxel is compressed, or none reaches the contact threshold: every result is zero."""
    COMPRESSION_ONLY = 2
    """No taxel is under traction: tangential forces are zero and f_z = C33^-1 b, unscaled."""
    NO_DIRECTION = 4
    """Both centroids coincide: phi = 0 is assumed."""
    VANISHING_DENOMINATOR = 8
    """Eqs. 17/18 have (almost) no denominator: the dependent friction is set to zero."""
    DEPENDENT_OUT_OF_RANGE = 16
    """The dependent friction of the chosen candidate lies outside [-1, 1]."""
    INPUT_SATURATED = 32
    """A taxel sits at an end of the converter's range."""
    OUTPUT_SATURATED = 64
    """A result does not fit its output word and was limited."""
    IMPLAUSIBLE = 128
    """The learned estimator is not sure of its resultant, or that pulls (:mod:`tfra.model.learned`)."""


OF_CORES = tuple(flag for flag in Status if flag is not Status.IMPLAUSIBLE)
"""Status bits that TFRA and its cores set."""


@dataclass(frozen=True)
class Direction:
    """Direction of the tangential force per frame (Eq. 11) and the swept variable (Fig. 3); arrays ``(n,)``."""

    cos: Floats
    sin: Floats
    sweep_y: Bools
    """True where mu_y is the independent variable."""
    negative: Bools
    """True where the sweep runs over [-1, 0]."""


@dataclass(frozen=True)
class Sweep:
    """The whole sweep, for inspection; arrays ``(n, steps + 1)``, in Pa and in sweep order."""

    mu: Floats
    b_z: Floats
    b_xy: Floats
    plateau: Bools


@dataclass(frozen=True)
class Result:
    """The estimate of TFRA, per frame: forces in N, angles in degrees.

    ``forces (n, 3, rows, columns)``, ``resultant (n, 3)``; ``phi_deg`` in [0, 360), ``mu`` (Eq. 15), ``mu_x``,
    ``mu_y`` (Eqs. 26, 27), ``sweep_index`` and ``status`` of shape ``(n,)``; ``sweep`` when asked for.  Other
    estimators have the same result; without a sweep, ``sweep_index`` is -1.  Of the learned
    estimator alone: ``uncertainty (n,)`` in N, how unsure it is of the resultant, the ``threshold`` of
    ``uncertainty_share`` over which a frame is ``IMPLAUSIBLE``, and ``residual (n,)``, the share of a frame's stress
    that its forces leave unexplained.  A core may leave out the forces at the taxels: they are NaN.
    """

    forces: Floats
    resultant: Floats
    phi_deg: Floats
    mu: Floats
    mu_x: Floats
    mu_y: Floats
    sweep_index: Ints
    status: Ints
    sweep: Sweep | None = None
    uncertainty: Floats | None = None
    threshold: float | None = None
    residual: Floats | None = None

    @property
    def resultant_alone(self) -> bool:
        """Whether there are no forces at the taxels."""
        return bool(self.forces.size and np.isnan(self.forces).all())

    @property
    def uncertainty_share(self) -> Floats | None:
        """The uncertainty over |F_z| ``(n,)``; NaN where F_z is zero."""
        if self.uncertainty is None:
            return None
        size = np.abs(self.resultant[:, 2])
        return np.divide(self.uncertainty, size, out=np.full_like(size, np.nan), where=size > 0)


def joined(results: Sequence[Result]) -> Result:
    """One result of the frames of all ``results`` of an estimator, without their sweeps."""
    first = results[0]
    names = [each.name for each in fields(Result) if isinstance(getattr(first, each.name), np.ndarray)]
    arrays: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in results]) for name in names}
    return replace(first, sweep=None, **arrays)


def check_frames(sensor: SensorArray, frames: npt.ArrayLike) -> Floats:
    """``frames`` as float64 of shape ``(n, rows, columns)``.

    Raises ``ValueError`` for another shape and for values that are not finite, naming the first one.
    """
    array = np.asarray(frames, dtype=np.float64)
    if array.ndim != 3 or array.shape[1:] != (sensor.rows, sensor.columns):
        raise ValueError(f"frames: shape (n, {sensor.rows}, {sensor.columns}) is needed, got {array.shape}")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        raise ValueError("frames: frame {}, row {}, column {} is not finite".format(*bad[0]))
    return array


def in_contact(b: Floats, threshold: float) -> Bools:
    """Which frames of ``b (n, m)`` have a taxel below zero and one outside [-threshold, threshold)."""
    return np.asarray((b < 0).any(axis=1) & ((b < -threshold) | (b >= threshold)).any(axis=1))


def unit_scaled(vectors: Floats) -> tuple[Floats, Ints]:
    """Return ``vectors (n, m)`` divided by powers of two ``(n,)``, largest entries in [0.5, 1), and the exponents.

    Nothing is rounded, and products neither vanish nor overflow, however small or large the stress is.
    """
    exponents = np.frexp(np.abs(vectors).max(axis=1))[1].astype(np.int64)
    return np.ldexp(vectors, -exponents[:, None]), exponents


def tangential(resultant: Floats) -> Floats:
    """Modulus ``(n,)`` of the tangential force of ``resultant (n, 3)``, N."""
    return np.hypot(resultant[:, 0], resultant[:, 1])


def friction(resultant: Floats) -> Floats:
    """mu ``(n,)`` of ``resultant (n, 3)`` in N (Eq. 15): tangential over normal force, 0 without the latter."""
    normal = np.abs(resultant[:, 2])
    return np.divide(tangential(resultant), normal, out=np.zeros(len(normal)), where=normal > 0)


def direction_deg(resultant: Floats) -> tuple[Floats, Bools]:
    """phi ``(n,)`` in degrees, in [0, 360) (Eq. 16), and where there is none: there it is 0."""
    still = tangential(resultant) <= STILL * np.abs(resultant[:, 2])
    phi = np.degrees(np.arctan2(resultant[:, 1], resultant[:, 0])) % 360.0 % 360.0  # -1e-20 % 360 is 360
    return np.where(still, 0.0, phi), still


class Tfra:
    """The algorithm for one sensor and one sweep grid of ``steps`` + 1 candidates.

    ``plateau_tolerance`` and ``contact_threshold`` in Pa; frames within [-threshold, threshold) are no contact.
    ``ops`` replaces the sensor's own operators, for instance by filtered ones.
    """

    def __init__(
        self,
        sensor: SensorArray,
        steps: int = 100,
        plateau_tolerance: float = 0.0,
        ops: Operators | None = None,
        contact_threshold: float = 0.0,
    ) -> None:
        if steps < 1:
            raise ValueError(f"steps: at least 1 is needed, got {steps}")
        if not plateau_tolerance >= 0:
            raise ValueError(f"plateau_tolerance: zero or more is needed, got {plateau_tolerance}")
        if not contact_threshold >= 0:
            raise ValueError(f"contact_threshold: zero or more is needed, got {contact_threshold}")
        self.sensor = sensor
        self.steps = steps
        self.plateau_tolerance = plateau_tolerance
        self.contact_threshold = contact_threshold
        self._ops = ops or operators(sensor)
        self._normal = self._ops.c33 @ self._ops.pinv3
        self._x, self._y = sensor.positions()

    @classmethod
    def of(cls, choices: Choices, ops: Operators | None = None) -> "Tfra":
        """The algorithm with the search and the contact threshold of ``choices``."""
        search, adc = choices.search, choices.adc
        tolerance, threshold = search.tolerance * adc.lsb, adc.threshold * adc.lsb
        return cls(choices.sensor, search.steps, tolerance, ops, threshold)

    def __call__(self, frames: npt.ArrayLike, *, keep_sweep: bool = False) -> Result:
        """Forces of ``frames (n, rows, columns)`` in Pa; raises ``ValueError`` for a wrong shape or NaN."""
        b = check_frames(self.sensor, frames).reshape(-1, self.sensor.taxels)
        contact, traction = in_contact(b, self.contact_threshold), np.asarray((b > 0).any(axis=1))
        regular = contact & traction
        direction, v_zero = self._direction(b, regular)
        n = self._weights(b, regular)
        by_x, by_y, by_z = (n @ c.T for c in (self._ops.c31, self._ops.c32, self._ops.c33))
        d0, d1, d2 = b + by_z, -by_x, -by_y
        alpha, beta, vanishing = self._dependent(direction, n, d0, d1, d2, regular)
        swap = direction.sweep_y[:, None]
        d_ind, d_dep = np.where(swap, d2, d1), np.where(swap, d1, d2)
        e0, e1 = d0 + alpha[:, None] * d_dep, d_ind + beta[:, None] * d_dep
        p, q = e0 @ self._normal.T - by_z, e1 @ self._normal.T
        index, sweep = self._search(b, p, q, direction, keep_sweep)
        index = np.where(regular, index, 0)
        mu_ind = np.where(regular, self._grid(direction, index), 0.0)
        mu_dep = np.where(regular, alpha + beta * mu_ind, 0.0)
        mu_x = np.where(direction.sweep_y, mu_dep, mu_ind)
        mu_y = np.where(direction.sweep_y, mu_ind, mu_dep)
        forces = self._forces(b, n, e0 + mu_ind[:, None] * e1, mu_x, mu_y, contact, regular)
        resultant = forces.sum(axis=2)  # Eq. 12
        status = (
            np.where(contact, 0, Status.NO_CONTACT)
            | np.where(contact & ~traction, Status.COMPRESSION_ONLY, 0)
            | np.where(regular & v_zero, Status.NO_DIRECTION, 0)
            | np.where(regular & vanishing, Status.VANISHING_DENOMINATOR, 0)
            | np.where(regular & (np.abs(mu_dep) > 1 + TIE), Status.DEPENDENT_OUT_OF_RANGE, 0)
        ).astype(np.int64)
        phi = np.where(regular, np.degrees(np.arctan2(direction.sin, direction.cos)) % 360.0, 0.0)
        phi[phi == 360.0] = 0.0  # what % makes of the smallest negative angles
        shape = (len(b), 3, self.sensor.rows, self.sensor.columns)
        return Result(forces.reshape(shape), resultant, phi, friction(resultant), mu_x, mu_y, index, status, sweep)

    def _direction(self, b: Floats, regular: Bools) -> tuple[Direction, Bools]:
        """Unit vector along c - t (Eqs. 11, 19-22), cleared of its denominators, and where it vanishes."""
        b, _ = unit_scaled(b)
        compression, traction = np.minimum(b, 0.0), np.maximum(b, 0.0)  # Eqs. 19, 20
        sum_c, sum_t = compression.sum(axis=1), traction.sum(axis=1)
        # (c - t) * |sum_c| * sum_t; the origin is the array's centre, which shortens the terms
        vx, vy = (
            (traction @ (pos - pos.mean())) * sum_c - (compression @ (pos - pos.mean())) * sum_t
            for pos in (self._x, self._y)
        )
        length = np.hypot(vx, vy)
        vanishing = ~(length > 1e-13 * np.abs(sum_c * sum_t) * (self._x[-1] + self._y[-1]))
        usable = regular & ~vanishing
        cos = np.divide(vx, length, out=np.ones(len(b)), where=usable)
        sin = np.divide(vy, length, out=np.zeros(len(b)), where=usable)
        sweep_y = np.abs(sin) > np.abs(cos) * (1 + TIE)  # Fig. 3
        return Direction(cos, sin, sweep_y, np.where(sweep_y, sin, cos) < 0), vanishing

    def _weights(self, b: Floats, regular: Bools) -> Floats:
        """n = -w_z >= 0 (Eq. 9); frames without traction keep the unclipped C33^-1 b, which solves them."""
        w_z = b @ self._ops.c33_inv.T
        return np.where(regular[:, None], np.maximum(-w_z, 0.0), -w_z)

    def _dependent(
        self, direction: Direction, n: Floats, d0: Floats, d1: Floats, d2: Floats, regular: Bools
    ) -> tuple[Floats, Floats, Bools]:
        """alpha, beta of mu_dep = alpha + beta * mu_ind (Eqs. 17, 18 times cos phi) and where they vanish."""
        col1, col2 = (pinv.sum(axis=0) for pinv in (self._ops.pinv1, self._ops.pinv2))
        total = n.sum(axis=1)
        a10, a11, a12 = d0 @ col1, total + d1 @ col1, d2 @ col1  # Eq. 12
        a20, a21, a22 = d0 @ col2, d1 @ col2, total + d2 @ col2
        cos, sin = direction.cos, direction.sin
        u0, ux, uy = a10 * sin - a20 * cos, a11 * sin - a21 * cos, a22 * cos - a12 * sin
        # mu_y = (u0 + mu_x ux) / uy, and the other way round mu_x = (mu_y uy - u0) / ux
        den = np.where(direction.sweep_y, ux, uy)
        num0, num1 = np.where(direction.sweep_y, -u0, u0), np.where(direction.sweep_y, uy, ux)
        largest = np.maximum(np.abs(num0), np.abs(num1))
        vanishing = ~(largest < COEFFICIENT_LIMIT * np.abs(den))
        usable = regular & ~vanishing
        alpha = np.divide(num0, den, out=np.zeros(len(n)), where=usable)
        beta = np.divide(num1, den, out=np.zeros(len(n)), where=usable)
        return alpha, beta, vanishing

    def _grid(self, direction: Direction, index: Ints) -> Floats:
        """mu_ind at ``index`` (any shape starting with n): k/K, or (k - K)/K on the negative side."""
        start = np.where(direction.negative, self.steps, 0).reshape(-1, *[1] * (index.ndim - 1))
        return np.asarray((index - start) / self.steps)

    def _search(self, b: Floats, p: Floats, q: Floats, direction: Direction, keep: bool) -> tuple[Ints, Sweep | None]:
        """Index of the smallest B^z, ties by B^xy, then first in sweep order (Eqs. 23, 25-27)."""
        count, candidates = len(b), self.steps + 1
        mu = self._grid(direction, np.broadcast_to(np.arange(candidates), (count, candidates)))
        b_z, b_xy = np.empty((count, candidates)), np.empty((count, candidates))
        measured = np.maximum(b, 0.0).sum(axis=1, keepdims=True)
        chunk = max(1, _CHUNK_BYTES // (8 * candidates * max(1, b.shape[1])))
        for start in range(0, count, chunk):
            part = slice(start, start + chunk)
            normal = mu[part, :, None] * q[part, None, :]
            normal += p[part, None, :]
            b_xy[part] = np.maximum(b[part, None, :] - normal, 0.0).sum(axis=2)  # Eq. 24, as b - C33 f_z
            b_z[part] = np.maximum(normal, 0.0, out=normal).sum(axis=2)  # Eq. 23
        b_xy = np.abs(b_xy - measured)  # Eq. 25
        plateau = b_z <= b_z.min(axis=1, keepdims=True) + self.plateau_tolerance
        index = np.where(plateau, b_xy, np.inf).argmin(axis=1)
        return index, Sweep(mu, b_z, b_xy, plateau) if keep else None

    def _forces(
        self, b: Floats, n: Floats, d: Floats, mu_x: Floats, mu_y: Floats, contact: Bools, regular: Bools
    ) -> Floats:
        """Scaled forces ``(n, 3, m)`` of the chosen candidate (Eqs. 10 and 28-31)."""
        f_x, f_y, f_z = (d @ pinv.T for pinv in (self._ops.pinv1, self._ops.pinv2, self._ops.pinv3))
        forces = np.stack([f_x + mu_x[:, None] * n, f_y + mu_y[:, None] * n, f_z - n], axis=1)
        total, exponent = unit_scaled(forces.sum(axis=2))
        f_star = np.ldexp(np.linalg.norm(total, axis=1), exponent)  # Eq. 30
        f_sens = np.abs(b).sum(axis=1) * self.sensor.taxel_area  # Eq. 29
        gain = np.divide(f_sens, f_star, out=np.zeros(len(b)), where=f_star > 0)  # Eq. 31
        gain = np.where(contact, np.where(regular, gain, 1.0), 0.0)
        forces *= gain[:, None, None]
        forces[~regular, :2] = 0.0
        return forces
