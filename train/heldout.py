"""Held-out errors of a network of an array: frames of the exact series with contacts that no training sees."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.metrics import errors
from tfra.model.sensor import SensorArray
from tfra.model.tfra import direction_deg, friction

NOISES = (0.0, 1e-3, 1e-2)
"""Standard deviations of the noise over each frame's peak."""

COUNT, SEED = 2000, 20_000
"""Held-out contacts and their seed."""

BITS, LEVELS = 14, (0.1, 0.95)
"""Of the converter; range of the peaks, as shares of its full scale."""

PERCENTILES = (50, 95)

TABLE = {"mu": "mu_abs", "phi_deg": "phi_deg", "force_percent": "force_percent_of_resultant"}
"""Names of the errors, and their keys in :data:`tfra.model.metrics.ERRORS`."""

FALSE_ALARMS, QUIET, LIMIT_SEED = 0.02, 1e-3, 10_000
"""Share of single contacts that may be over the threshold, the noise that they have, and their seed."""

Estimate = Callable[[Floats], Floats]
"""Function of normal forces ``(n, m)`` at every taxel that returns outputs ``(n, 4)`` of the network; all in N."""


@dataclass(frozen=True, eq=False)
class Resultants:
    """Forces ``(n, 3)`` in N with their friction and direction, as :mod:`tfra.model.metrics` reads them."""

    resultant: Floats

    @property
    def mu(self) -> Floats:
        """Friction (Eq. 15), ``(n,)``."""
        return friction(self.resultant)

    @property
    def phi_deg(self) -> Floats:
        """Direction of the tangential force in [0, 360), ``(n,)``."""
        return direction_deg(self.resultant)[0]


@dataclass(frozen=True, eq=False)
class Series:
    """Exact frames ``(n, m)`` in N of contacts with resultants ``force (n, 3)``.

    ``noise (n, m)`` has the size of each frame's peak, ``step (n, 1)`` is that of the converter, both in N.
    """

    force: Floats
    exact: Floats
    noise: Floats
    step: Floats

    @classmethod
    def of(cls, sensor: SensorArray, count: int, seed: int) -> "Series":
        """Random contacts anywhere on ``sensor``."""
        rng = np.random.default_rng(seed)
        contacts = any_contacts(sensor, count, rng)
        exact = frames(sensor, contacts).reshape(count, -1) * sensor.taxel_area
        peak = np.abs(exact).max(axis=1, keepdims=True)
        step = peak / (rng.uniform(*LEVELS, (count, 1)) * 2 ** (BITS - 1))
        return cls(contacts.force, exact, peak * rng.normal(size=exact.shape), step)

    def read(self, level: float) -> Floats:
        """Frames with noise of ``level``, as the converter reads them."""
        return np.asarray(np.rint((self.exact + level * self.noise) / self.step) * self.step)


def held_out(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> dict[str, float]:
    """Return median and 95th percentile of every error of ``TABLE`` at every noise, named like ``mu_95_at_0.001``."""
    series, summary = Series.of(sensor, count, SEED), {}
    for level in NOISES:
        every = errors(Resultants(series.force), Resultants(estimate(series.read(level))[:, :3]))
        for key, name in TABLE.items():
            for share in PERCENTILES:
                summary[f"{key}_{share}_at_{level:g}"] = float(np.percentile(every[name], share))
    return summary


def threshold(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> float:
    """Return the uncertainty over |F_z| that ``FALSE_ALARMS`` of quiet single contacts exceed."""
    outputs = estimate(Series.of(sensor, count, LIMIT_SEED).read(QUIET))
    return float(np.quantile(outputs[:, 3] / np.abs(outputs[:, 2]), 1 - FALSE_ALARMS))
