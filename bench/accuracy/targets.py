"""What the learned estimator is to reach on every single sensor, and whether it does."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.accuracy.estimators import LEARNED
from bench.accuracy.measure import PERCENTILES
from bench.accuracy.scenes import QUIET

COARSE = 1.3
"""Mean pitch over thickness from which the limits of coarse sensors hold."""


@dataclass(frozen=True)
class Target:
    """An error in a scene that is to be at most ``limit``, or ``coarse`` on coarse sensors if that differs."""

    scene: str
    measure: str
    percentile: int
    limit: float
    coarse: float | None = None

    def limit_of(self, coarseness: float) -> float:
        """The limit of a sensor whose mean pitch over thickness is ``coarseness``."""
        return self.limit if self.coarse is None or coarseness < COARSE else self.coarse

    def found(self, sensor: Mapping[str, Any]) -> float:
        """The error in one sensor's record."""
        both = sensor["scenes"][self.scene][LEARNED][self.measure]
        return float(both[PERCENTILES.index(self.percentile)])


TARGETS = (
    Target(QUIET, "mu", 50, 0.02, 0.03),
    Target(QUIET, "mu", 95, 0.09, 0.14),
    Target(QUIET, "phi_deg", 50, 2.0),
    Target(QUIET, "force_percent", 50, 3.5, 5.0),
    Target(QUIET, "force_percent", 95, 11.0, 15.0),
    Target("1 % noise", "mu", 50, 0.07),
    Target("1 % noise, mean of 16 frames", "mu", 50, 0.025),
    *(Target(f"offset of {size} %", "mu", 50, 0.025) for size in ("+0.5", "+1", "−1")),
    Target("gains spread by 10 %", "mu", 50, 0.035),
    Target("a dead taxel", "mu", 50, 0.03),
    Target("cover that goes on", "mu", 50, 0.04),
    *(Target(f"ν = {nu}", "mu", 50, 0.03) for nu in ("0.45", "0.5")),
    *(Target(shape, "mu", 50, 0.03) for shape in ("ring", "flat punch", "partial slip", "tilted ellipse")),
)
"""On random contacts."""

PAPER = 0.03
"""How far the median friction found for the paper's contacts may be from the true one, for each of them."""

AGREEMENT = {"mu": 0.002, "phi_deg": 0.1}
"""99th percentiles of the difference between the fixed and the float estimator."""


def verdict(found: float, limit: float, digits: int) -> str:
    """``found`` with a tick, or with the amount that it is over the ``limit``."""
    over = np.format_float_positional(found - limit, precision=2, fractional=False, trim="-")
    return f"{found:.{digits}f} " + ("✓" if found <= limit else f"(+{over})")


def furthest(found: Mapping[str, float]) -> float:
    """Largest distance of the median found from the true friction, over the contacts of one sensor of the paper."""
    return max(abs(median - float(mu)) for mu, median in found.items())
