"""What a calibration says of the one sensor that a network is trained for."""

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from tfra.model.arrays import Floats, Ints, Singles
from tfra.model.fixed.dead_taxels import repairs
from tfra.model.fixed.repair import filled
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Calibration, Cover

SEED = 22_000
"""Of the gains of held-out frames."""


def _none() -> Ints:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Known:
    """``gain_error (m,)``, standard deviations of the gains, relative, and the ``cover``; None where they are unknown.

    ``dead (k,)``: numbers of the taxels that are dead in every frame; ``repairs``: the front end's table, which
    replaces them.  ``facts``: all of this for the file of weights; None if no sensor is known.
    """

    gain_error: Singles | None = None
    cover: Cover | None = None
    dead: Ints = field(default_factory=_none)
    repairs: Ints = field(default_factory=_none)
    facts: dict[str, Any] | None = None

    @classmethod
    def of(cls, calibration: Calibration, sensor: SensorArray) -> Self:
        """What ``calibration`` says of ``sensor``, whose front end has CONFIG's cover, as that of recordings."""
        error, cover, dead = calibration.gain_error, calibration.cover, calibration.dead
        return cls(
            gain_error=None if error is None else error.ravel().astype(np.float32),
            cover=cover,
            dead=np.flatnonzero(dead),
            repairs=repairs(sensor, dead),
            facts={
                "gain_error": None if error is None else error.tolist(),
                "cover": cover and cover.model_dump(),
                "dead": np.argwhere(dead).tolist(),
            },
        )

    def under_cover(self, sensor: SensorArray) -> SensorArray:
        """``sensor`` with the thickness that acts."""
        return replace(sensor, thickness=1e-3 * self.cover.thickness_mm) if self.cover else sensor

    def delivered(self, n: Floats) -> Floats:
        """Frames ``n (k, m)`` as the front end delivers them: with gains that are a little wrong, and with repairs."""
        if self.gain_error is not None:
            n = n * (1 + self.gain_error * np.random.default_rng(SEED).standard_normal(n.shape))
        return filled(n, self.repairs)


UNKNOWN = Known()
"""Any sensor."""
