"""Errors on held-out frames of the exact series, whose contacts, shapes and seeds no training sees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.metrics import errors
from tfra.model.resultant import direction, friction
from tfra.model.sensor import SensorArray

NOISES = (0.0, 1e-3, 1e-2)
"""Standard deviations of the noise over each frame's peak."""

COUNT, SEED = 2000, 20_000
"""Held-out contacts and their seed."""

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
        return direction(self.resultant)[0]


def held_out(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> dict[str, float]:
    """Return median and 95th percentile of every error of ``TABLE`` at every noise, named like ``mu_95_at_0.001``."""
    contacts, exact, noise = _frames(sensor, count, SEED)
    truth = Resultants(np.array([contact.force for contact in contacts]))
    found = {}
    for level in NOISES:
        every = errors(truth, Resultants(estimate(exact + level * noise)[:, :3]))
        for key, name in TABLE.items():
            for share in PERCENTILES:
                found[f"{key}_{share}_at_{level:g}"] = float(np.percentile(every[name], share))
    return found


def threshold(sensor: SensorArray, estimate: Estimate, count: int = COUNT) -> float:
    """Return the uncertainty over |F_z| that ``FALSE_ALARMS`` of quiet single contacts exceed."""
    _, exact, noise = _frames(sensor, count, LIMIT_SEED)
    outputs = estimate(exact + QUIET * noise)
    return float(np.quantile(outputs[:, 3] / np.abs(outputs[:, 2]), 1 - FALSE_ALARMS))


def _frames(sensor: SensorArray, count: int, seed: int) -> tuple[list[Contact], Floats, Floats]:
    """Contacts, their exact frames ``(n, m)`` in N, and noise as large as the peak of each."""
    rng = np.random.default_rng(seed)
    contacts = random_contacts(sensor, count, rng)
    exact = frames(sensor, contacts).reshape(count, -1) * sensor.taxel_area
    return contacts, exact, np.abs(exact).max(axis=1, keepdims=True) * rng.normal(size=exact.shape)
