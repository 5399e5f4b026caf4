"""Gains, cover and presses fitted to readings together: a posterior of all that is unknown, by nonlinear least squares.

The reading of a taxel is its sensitivity, 1 / gain, times the stress of a press (:mod:`tfra.calibrate.response`).  Of
each press, place, radius, the error of its force and its tangential part are unknown; of the cover, thickness and
Poisson's ratio; of the array, the sensitivities.  What is expected of each unknown before is one more row of residuals.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.ndimage import uniform_filter
from scipy.sparse.linalg import splu

from tfra.calibrate.response import SOFTEST, STIFFEST, Indenter, Presses, Response, Stress
from tfra.model.arrays import Bools, Floats
from tfra.model.sensor import SensorArray

THICKNESS = 0.5
"""Standard deviation of what is expected of the thickness' logarithm, about that of CONFIG."""

POISSON = 0.475, 0.015
"""What is expected of Poisson's ratio: of rubber."""

RADIUS, FINGER, PUNCH = 0.15, 0.5, 0.01
"""Standard deviation of a radius' logarithm: of a ball about Hertz's law, of a finger, of a flat punch."""

TILT = 0.02
"""Standard deviation of the tangential part of a normal load, over that load."""

NEAR = 1.6
"""Taxels that tell where a press is, before the fit: so many pitches or thicknesses about the peak."""

DAMPING, STUCK, DONE = 0.1, 1e10, 1e-7
"""Damping of the first step, and where there is no lower sum of squares; relative gain of the last step."""

FARTHEST = 0.3
"""Largest step of an unknown: lengths in thicknesses, forces and sensitivities over the usual ones."""

MOST_STEPS = 100

SPREAD = 0.3
"""Standard deviation of the sensitivities over their mean, until the data show it."""

_COMMON, _EACH = 4, 6
"""Unknowns of all presses: logarithm of the thickness, ratio, radius of 1 N, mean sensitivity; and of each press."""


class Known(NamedTuple):
    """What is known of n loads: ``normal (n,)`` and ``tangential (n,)`` forces, N, > 0 and >= 0.

    ``even (n,)``: the force is that of an even pressure on all taxels.  ``error (n,)``, relative, of the forces;
    ``indenter (n,)`` and its ``radius (n,)``, m.
    """

    normal: Floats
    tangential: Floats
    even: Bools
    error: Floats
    indenter: tuple[Indenter, ...]
    radius: Floats


class Readings(NamedTuple):
    """Deviations ``value (n, m)`` from rest in Pa of the gain 1, compression negative; ``error (n, m)`` of each.

    ``told (n, m)``: those that count.
    """

    value: Floats
    error: Floats
    told: Bools


@dataclass(frozen=True, eq=False)
class Fit:
    """What is known after, as values and standard deviations ``_error``.

    ``sensitivity (m,)``: reading over stress; ``place (n, 2)``, m; ``tangential (n, 2)``, N, with the covariances
    ``tangential_error (n, 2, 2)`` and ``place_error (n, 2, 2)``; ``scale (n,)``: force over that of the table.
    ``stress (n, m)``: that of the presses, Pa.  ``cost``: half of the sum of all squares; ``chi``: of residuals over
    their errors, per degree of freedom.  ``vector``: all unknowns, for another fit.
    """

    thickness: float
    thickness_error: float
    poisson: float
    poisson_error: float
    sensitivity: Floats
    sensitivity_error: Floats
    place: Floats
    place_error: Floats
    tangential: Floats
    tangential_error: Floats
    scale: Floats
    radius: Floats
    stress: Floats
    cost: float
    chi: float
    margin: float
    vector: Floats


class _Unknowns(NamedTuple):
    """The vector of unknowns by their names; lengths in m."""

    log_thickness: float
    poisson: float
    log_unit_radius: float
    mean: float
    sensitivity: Floats
    x: Floats
    y: Floats
    log_radius: Floats
    log_scale: Floats
    tangential: Floats

    @classmethod
    def of(cls, vector: Floats, taxels: int, length: float) -> "_Unknowns":
        each = vector[_COMMON + taxels :].reshape(_EACH, -1)
        log_thickness, poisson, log_unit_radius, mean = vector[:_COMMON].tolist()
        x, y, log_radius, log_scale = length * each[0], length * each[1], each[2], each[3]
        sensitivity = vector[_COMMON : _COMMON + taxels]
        return cls(log_thickness, poisson, log_unit_radius, mean, sensitivity, x, y, log_radius, log_scale, each[4:])


class _Problem:
    """The residuals of ``readings`` of ``known`` presses on ``sensor``, and their derivatives."""

    def __init__(self, sensor: SensorArray, margin: float, known: Known, readings: Readings, spread: float) -> None:
        self.sensor, self.known, self.readings, self._spread = sensor, known, readings, spread
        self._response, self._length = Response(sensor, margin), sensor.thickness
        self.rows, self.taxels = np.nonzero(readings.told)
        self._weights = 1.0 / readings.error[readings.told]
        flat, ball = (np.array([kind is which for kind in known.indenter]) for which in (Indenter.FLAT, Indenter.BALL))
        self._flat, self._ball = flat, ball.astype(np.float64)
        hertz = np.log(known.normal * known.radius) / 3
        usual = np.where(ball, hertz - (hertz[ball].mean() if ball.any() else 0.0), math.log(1.5 * self._length))
        self._usual_radius = np.where(flat, np.log(known.radius), usual)
        self._radius_error = np.select([flat, ball], [PUNCH, RADIUS], FINGER)
        self._pressure = known.normal / (sensor.taxels * sensor.taxel_area)
        balance = -np.where(readings.told, readings.value, 0.0).sum(axis=1) * sensor.taxel_area / known.normal
        self._usual_sensitivity = float(np.median(balance))
        self._last: tuple[bytes, Floats, Stress] | None = None

    def start(self) -> Floats:
        """Places by the centroids of the readings about their peaks, everything else as expected."""
        x, y = self.sensor.positions()
        pressed = np.where(self.readings.told, np.maximum(-self.readings.value, 0.0), 0.0)
        frames = pressed.reshape(-1, self.sensor.rows, self.sensor.columns)
        peak = uniform_filter(frames, (0, 3, 3), mode="constant").reshape(pressed.shape).argmax(axis=1)[:, None]
        reach = NEAR * max(self.sensor.pitch_x, self.sensor.pitch_y, self._length)
        weights = pressed * (np.hypot(x - x[peak], y - y[peak]) < reach)
        weights /= weights.sum(axis=1, keepdims=True)
        usual = math.log(self._length)
        common = [usual, POISSON[0], usual, self._usual_sensitivity]
        nothing = np.zeros((3, len(weights)))
        places = np.stack([weights @ x, weights @ y]) / self._length
        each = np.concatenate([places, (self._usual_radius + self._ball * usual)[None], nothing])
        return np.concatenate([common, np.full(self.sensor.taxels, self._usual_sensitivity), each.ravel()])

    @cached_property
    def reach(self) -> Floats:
        """The largest step of each unknown: what is hardly told, as the radius of a small contact, would go far."""
        reach = np.full(_COMMON + self.sensor.taxels + _EACH * len(self.known.normal), FARTHEST)
        reach[3 : _COMMON + self.sensor.taxels] *= abs(self._usual_sensitivity)
        return reach

    def bounded(self, vector: Floats) -> Floats:
        """``vector`` within the limits of Poisson's ratio."""
        vector[1] = min(max(vector[1], STIFFEST), SOFTEST)
        return vector

    def of(self, vector: Floats) -> _Unknowns:
        """The unknowns in ``vector``."""
        return _Unknowns.of(vector, self.sensor.taxels, self._length)

    def stress(self, vector: Floats) -> tuple[Floats, Stress]:
        """Forces ``(n, 3)`` of the presses in ``vector``, and their stress with its derivatives."""
        if self._last is None or self._last[0] != vector.tobytes():
            u = self.of(vector)
            pulled = u.tangential * self.known.normal
            force = np.concatenate([pulled, -self.known.normal[None]]).T * np.exp(u.log_scale)[:, None]
            presses = Presses(u.x, u.y, u.log_radius, force, self._flat)
            stress = self._response(u.log_thickness, u.poisson, presses)
            self._last = vector.tobytes(), force, self._with_even(stress, self._pressure * np.exp(u.log_scale))
        return self._last[1:]

    def _with_even(self, stress: Stress, pressure: Floats) -> Stress:
        """``stress``, but that of even loads is their ``pressure (n,)``, and depends on nothing else."""
        even = self.known.even[:, None]
        found = Stress(*(np.where(even, 0.0, part) for part in stress))
        return found._replace(value=np.where(even, -pressure[:, None], found.value))

    def residuals(self, vector: Floats) -> Floats:
        """Of the readings, row by row, then of what is expected; all over their standard deviations."""
        _, stress = self.stress(vector)
        u = self.of(vector)
        reading = self.readings.value[self.rows, self.taxels] - u.sensitivity[self.taxels] * self._told(stress.value)
        expected = (
            [(u.log_thickness - math.log(self._length)) / THICKNESS, (u.poisson - POISSON[0]) / POISSON[1]],
            [(u.log_unit_radius - math.log(self._length)) / FINGER, 0.0],
            (u.sensitivity - u.mean) / self._sensitivity_error,
            *(self.known.even * place / self._length for place in (u.x, u.y)),
            (u.log_radius - self._usual_radius - self._ball * u.log_unit_radius) / self._radius_error,
            u.log_scale / self.known.error,
            (u.tangential / self._tilt).ravel(),
        )
        return np.concatenate([reading * self._weights, *expected])

    def jacobian(self, vector: Floats) -> sparse.csr_matrix:
        """The derivatives of the residuals."""
        _, stress = self.stress(vector)
        u = self.of(vector)
        count, taxels, normal = len(self.known.normal), self.sensor.taxels, self.known.normal
        pull = stress.force[:2] * (normal * np.exp(u.log_scale))[:, None]
        each = (stress.x * self._length, stress.y * self._length, stress.log_radius, stress.value, *pull)
        factor = -u.sensitivity[self.taxels] * self._weights
        columns = {0: stress.log_thickness, 1: stress.poisson}
        values = [self._told(value) * factor for value in (*columns.values(), *each)]
        values.append(-self._told(stress.value) * self._weights)
        own = _COMMON + taxels + self.rows
        places = [np.full_like(self.rows, column) for column in columns]
        places += [own + count * kind for kind in range(_EACH)]
        places.append(_COMMON + self.taxels)
        rows = np.tile(np.arange(len(self.rows)), len(values))
        shape = len(self.rows), len(vector)
        readings = sparse.csr_matrix((np.concatenate(values), (rows, np.concatenate(places))), shape=shape)
        return sparse.vstack([readings, self._expected]).tocsr()

    @cached_property
    def _expected(self) -> sparse.csr_matrix:
        """The derivatives of what is expected, which are constant; places of even loads mean nothing, and stay."""
        count, taxels = len(self.known.normal), self.sensor.taxels
        even = self.known.even.astype(np.float64)
        common = [1 / THICKNESS, 1 / POISSON[1], 1 / FINGER]
        alike = np.full(taxels, 1 / self._sensitivity_error)
        each = [1 / self._radius_error, 1 / self.known.error, 1 / self._tilt, 1 / self._tilt]
        diagonal = np.concatenate([common, [0.0], alike, even, even, *each])
        matrix = sparse.diags(diagonal).tolil()
        first = _COMMON + taxels + 2 * count
        matrix[_COMMON : _COMMON + taxels, 3] = -alike[:, None]
        matrix[first : first + count, 2] = -(self._ball / self._radius_error)[:, None]
        return matrix.tocsr()

    @property
    def _sensitivity_error(self) -> float:
        return self._spread * abs(self._usual_sensitivity)

    @property
    def _tilt(self) -> Floats:
        return np.asarray(np.maximum(TILT, self.known.tangential / self.known.normal))

    def _told(self, values: Floats) -> Floats:
        return values[self.rows, self.taxels]


def fit(
    sensor: SensorArray,
    margin: float,
    known: Known,
    readings: Readings,
    spread: float = SPREAD,
    steps: int = MOST_STEPS,
    start: Fit | None = None,
) -> Fit:
    """Fit everything that is unknown of ``readings`` of ``known`` presses, in so many ``steps`` at most.

    ``margin``: the cover goes on so far beyond the array, m; ``spread``: of the sensitivities.  ``start``: a fit of the
    same readings under another cover.
    """
    problem = _Problem(sensor, margin, known, readings, spread)
    vector = _least(problem, problem.start() if start is None else start.vector, steps)
    u, (force, stress), residuals = problem.of(vector), problem.stress(vector), problem.residuals(vector)
    covariance = _Covariance(problem.jacobian(vector), sensor.taxels)
    count, size = len(known.normal), len(problem.rows)
    freedom = max(1, size - len(np.unique(problem.taxels)) - 3 * count)
    lengths, forces = sensor.thickness, (known.normal * np.exp(u.log_scale))[:, None, None]
    return Fit(
        thickness=math.exp(u.log_thickness),
        thickness_error=math.exp(u.log_thickness) * float(covariance.errors[0]),
        poisson=u.poisson,
        poisson_error=float(covariance.errors[1]),
        sensitivity=u.sensitivity,
        sensitivity_error=covariance.sensitivities,
        place=np.stack([u.x, u.y], axis=1),
        place_error=covariance.pairs(0, count) * lengths**2,
        tangential=force[:, :2],
        tangential_error=covariance.pairs(4, count) * forces**2,
        scale=np.exp(u.log_scale),
        radius=np.exp(u.log_radius),
        stress=stress.value,
        cost=float(residuals @ residuals) / 2,
        chi=float((residuals[:size] ** 2).sum() / freedom),
        margin=margin,
        vector=vector,
    )


def _least(problem: _Problem, vector: Floats, steps: int) -> Floats:
    """The unknowns of the least sum of squares, from ``vector`` on, by Levenberg and Marquardt (doi:10.1137/0111030).

    The normal equations are sparse and small: their factors take a tenth of the time of SciPy's ``least_squares``,
    which solves them by iterations.
    """
    damping = DAMPING
    residuals = problem.residuals(vector)
    cost = float(residuals @ residuals)
    for _ in range(steps):
        jacobian = problem.jacobian(vector)
        normal, slope = (jacobian.T @ jacobian).tocsc(), jacobian.T @ residuals
        diagonal = sparse.diags(normal.diagonal())
        while damping < STUCK:
            step = _step(normal + damping * diagonal, slope, vector)
            tried = problem.bounded(vector - np.clip(step, -problem.reach, problem.reach))
            residuals = problem.residuals(tried)
            if (lower := float(residuals @ residuals)) < cost:
                break
            damping *= 3
        else:
            break
        gained, vector, cost = cost - lower, tried, lower
        if gained < DONE * cost and damping < 1:
            break
        damping /= 3
    return vector


def _step(normal: sparse.spmatrix, slope: Floats, vector: Floats) -> Floats:
    """The step against ``slope``, along the limit of Poisson's ratio if it would leave it."""
    step = splu(normal.tocsc()).solve(slope)
    if not STIFFEST <= vector[1] - step[1] <= SOFTEST and vector[1] in (STIFFEST, SOFTEST):
        fixed = sparse.diags(np.where(np.arange(len(slope)) == 1, 1e12 * normal.diagonal()[1], 0.0))
        step = splu((normal + fixed).tocsc()).solve(slope)
    return np.asarray(step)


class _Covariance:
    """The inverse of J'J, whose part of the sensitivities is diagonal: a Schur complement leaves the other unknowns."""

    def __init__(self, jacobian: sparse.csr_matrix, taxels: int) -> None:
        normal = (jacobian.T @ jacobian).tocsr()
        which = np.zeros(normal.shape[0], dtype=np.bool_)
        which[_COMMON : _COMMON + taxels] = True
        diagonal = normal.diagonal()[which]
        mixed = normal[which][:, ~which].toarray() / diagonal[:, None]
        rest = normal[~which][:, ~which].toarray()
        self._rest = np.linalg.inv(rest - (mixed * diagonal[:, None]).T @ mixed)
        self.errors = np.sqrt(np.diag(self._rest))
        """Standard deviations of all but the sensitivities."""
        self.sensitivities = np.sqrt(1 / diagonal + ((mixed @ self._rest) * mixed).sum(axis=1))

    def pairs(self, kind: int, count: int) -> Floats:
        """Covariances ``(count, 2, 2)`` of two kinds of unknowns of each press, ``kind`` and the next one."""
        which = _COMMON + kind * count + np.arange(count) + count * np.arange(2)[:, None]
        return np.asarray(self._rest[which.T[:, :, None], which.T[:, None, :]])
