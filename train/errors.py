"""Errors on held-out frames of the exact series, whose contacts, shapes and seeds no training sees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import Seed, random_contacts
from tfra.model.metrics import errors
from tfra.model.sensor import SensorArray

NOISES = (0.0, 1e-3, 1e-2)
"""Standard deviations of the noise over each frame's peak."""

COUNT, SEED = 2000, 20_000
"""Held-out contacts and their seed."""

TABLE = {"mu": "mu_abs", "phi_deg": "phi_deg", "force_percent": "force_percent_of_resultant"}
"""Keys of a row, and those of :data:`tfra.model.metrics.ERRORS`."""

Estimate = Callable[[Floats], Floats]
"""Function of normal forces ``(n, m)`` at every taxel that returns resultants ``(n, 3)``; all in N."""


@dataclass(frozen=True, eq=False)
class Resultants:
    """Forces ``(n, 3)`` in N with their friction and direction, as :mod:`tfra.model.metrics` reads them."""

    resultant: Floats

    @property
    def mu(self) -> Floats:
        """Tangential over normal force (Eq. 15), ``(n,)``."""
        tangential = np.hypot(self.resultant[:, 0], self.resultant[:, 1])
        return np.asarray(tangential / np.maximum(np.abs(self.resultant[:, 2]), np.finfo(float).tiny))

    @property
    def phi_deg(self) -> Floats:
        """Direction of the tangential force in [0, 360), ``(n,)``."""
        return np.asarray(np.degrees(np.arctan2(self.resultant[:, 1], self.resultant[:, 0])) % 360.0)


def held_out(
    sensor: SensorArray, estimate: Estimate, count: int = COUNT, seed: Seed = SEED
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return median and 95th percentile of each error of ``TABLE`` by the noise: ``"0"``, ``"0.001"``, ``"0.01"``."""
    rng = np.random.default_rng(seed)
    contacts = random_contacts(sensor, count, rng)
    exact = frames(sensor, contacts).reshape(count, -1) * sensor.taxel_area
    noise = np.abs(exact).max(axis=1, keepdims=True) * rng.normal(size=exact.shape)
    truth = _truth(contacts)
    return {f"{level:g}": _row(truth, Resultants(estimate(exact + level * noise))) for level in NOISES}


def _truth(contacts: list[Contact]) -> Resultants:
    return Resultants(np.array([contact.force for contact in contacts]))


def _row(truth: Resultants, found: Resultants) -> dict[str, tuple[float, float]]:
    every = errors(truth, found)
    return {key: _percentiles(every[name]) for key, name in TABLE.items()}


def _percentiles(values: Floats) -> tuple[float, float]:
    median, high = np.percentile(values, (50, 95))
    return float(median), float(high)
