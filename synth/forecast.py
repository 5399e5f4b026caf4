"""Progress of the tools and time left: guessed from the core's size, corrected by the times of finished steps."""

from __future__ import annotations

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
    """Steps in their order, with the expected seconds of each; ``step`` is the current one.

    ``clock`` returns seconds, as ``time.monotonic``.
    """

    clock: Callable[[], float] = time.monotonic
    step: str = ESTIMATING
    expected: dict[str, float] = field(default_factory=dict)
    taken: dict[str, float] = field(default_factory=dict)
    """Seconds that finished steps took."""
    kept: set[str] = field(default_factory=set)
    """Steps whose results came from the cache; their times are ignored."""
    _since: float = 0.0

    def __post_init__(self) -> None:
        self._since = self.clock()

    def plan(self, lookup_tables: float, seeds: int) -> None:
        """Expect the times of a core of ``lookup_tables``."""
        each = {YOSYS: _SECONDS[YOSYS]} | {seed_name(seed): _SEED_S for seed in range(1, seeds + 1)}
        each |= {BITSTREAM: _SECONDS[BITSTREAM]} if seeds else {}
        self.expected = {step: _FIXED_S + seconds * lookup_tables for step, seconds in each.items()}

    def begin(self, step: str) -> None:
        """Begin ``step``; the time of the step before corrects those to come."""
        now = self.clock()
        before, self.step = self.step, step
        self.taken[before], self._since = now - self._since, now
        if before in self.expected and before not in self.kept:
            self._correct(before)

    def _correct(self, done: str) -> None:
        """Scale the expected times of later steps by measured over expected time."""
        ratio = self.taken[done] / self.expected[done]
        later = [step for step in self.expected if step not in self.taken]
        self.expected |= {step: self.expected[step] * ratio for step in later}

    @property
    def left(self) -> float:
        """Seconds to the end.  A step that exceeds its expected time is given a tenth of its time so far."""
        since = self.clock() - self._since
        later = [step for step in self.expected if step not in self.taken and step != self.step]
        here = max(self.expected.get(self.step, 0.0) - since, 0.1 * since)
        return here + sum(self.expected[step] for step in later)

    @property
    def share(self) -> float:
        """Elapsed share of the total time, 0 ... 1."""
        over = sum(self.taken.values()) + self.clock() - self._since
        return over / max(over + self.left, 1e-9)

    def __str__(self) -> str:
        return f"{self.step}: {100 * self.share:.0f} %, about {spoken(self.left)} left"


def spoken(seconds: float) -> str:
    """A time as text, in s, min or h."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    return f"{round(seconds / 60)} min" if seconds < 90 * 60 else f"{seconds / 3600:.1f} h"

