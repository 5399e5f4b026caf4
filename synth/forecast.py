"""Progress of the tools and time left: guessed from the core's size, corrected by the times of finished steps."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

ESTIMATING, YOSYS, BITSTREAM = "estimating", "yosys", "bitstream"

_FIXED_S = 10.0
"""Seconds that a tool needs for the smallest core."""
_SECONDS = {YOSYS: 2e-3, BITSTREAM: 5e-5}
_SEED_S = 15e-3
"""Seconds for each lookup table, as PyPI's tools took on one machine; a seed is placed and routed.  This is a guess,
which the time of the first tool corrects."""


def seed_name(seed: int) -> str:
    """The step that places and routes with ``seed``."""
    return f"place and route, seed {seed}"


@dataclass
class Forecast:
    """Seconds expected of ``step``, which runs, and of those after it; ``clock`` is as ``time.monotonic``."""

    clock: Callable[[], float] = time.monotonic
    step: str = ESTIMATING
    expected: dict[str, float] = field(default_factory=dict)
    cached: bool = False
    """Did the result of ``step`` come from the cache?  Then its time says nothing of the machine."""

    def __post_init__(self) -> None:
        self._start = self._since = self.clock()

    def plan(self, lookup_tables: float, seeds: int) -> None:
        """Expect the times of a core of ``lookup_tables``."""
        each = {YOSYS: _SECONDS[YOSYS]} | {seed_name(seed): _SEED_S for seed in range(1, seeds + 1)}
        each |= {BITSTREAM: _SECONDS[BITSTREAM]} if seeds else {}
        self.expected = {step: _FIXED_S + seconds * lookup_tables for step, seconds in each.items()}

    def begin(self, step: str) -> None:
        """Begin ``step``; measured over expected time of the step before scales the times of those to come."""
        now = self.clock()
        before = self.expected.pop(self.step, None)
        if before and not self.cached:
            self.expected = {name: seconds * (now - self._since) / before for name, seconds in self.expected.items()}
        self.step, self.cached, self._since = step, False, now

    @property
    def left(self) -> float:
        """Seconds to the end.  A step that exceeds its expected time is given a tenth of its time so far."""
        taken = self.clock() - self._since
        expected = self.expected.get(self.step, 0.0)
        return sum(self.expected.values()) - expected + max(expected - taken, 0.1 * taken)

    def __str__(self) -> str:
        elapsed, left = self.clock() - self._start, self.left
        return f"{self.step}: {100 * elapsed / max(elapsed + left, 1e-9):.0f} %, about {spoken(left)} left"


def spoken(seconds: float) -> str:
    """A time as text, in s, min or h."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    return f"{round(seconds / 60)} min" if seconds < 90 * 60 else f"{seconds / 3600:.1f} h"
