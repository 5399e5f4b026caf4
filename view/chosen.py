"""The frames of a page: those requested, thinned evenly if there is no room for all."""

import math
from dataclasses import dataclass

from tfra.view.resultfile import Recorded

MOST_BYTES = 15_000_000
"""Bytes of frames in a page; as text they are 20 MB."""

MOST_SWEEP_BYTES = 8_000_000
"""Bytes of sweeps, B^z and B^xy of all candidates."""


@dataclass(frozen=True)
class Chosen:
    """Frames ``shown`` of ``total``; every ``sweeps``-th has its sweep.  ``full``: there is no room for more."""

    shown: range
    total: int
    sweeps: int
    full: bool

    @classmethod
    def of(cls, results: list[Recorded], wanted: range) -> "Chosen":
        """The frames ``wanted``, or every second, third … of them where the results are too large."""
        total, taxels = len(results[0].stress), results[0].design.sensor.taxels
        frame = sum(frame_bytes(taxels, result.found.resultant_alone) for result in results)
        thinned = _step(len(wanted), frame, MOST_BYTES)
        shown = wanted[::thinned]
        sweep = sum(sweep_bytes(result.design.search.steps) for result in results if result.swept)
        return cls(shown, total, _step(len(shown), sweep, MOST_SWEEP_BYTES), thinned > 1)

    def __str__(self) -> str:
        """The sentence on the page."""
        first, last, step = self.shown.start, self.shown[-1], self.shown.step
        if len(self.shown) == self.total:
            sentence = f"All {self.total:,} frames are shown"
        else:
            which = (
                f"frames {first:,} to {last:,}" if step == 1 else f"every {_nth(step)} frame from {first:,} to {last:,}"
            )
            sentence = f"{len(self.shown):,} of {self.total:,} frames are shown: {which}"
            sentence += ", since there is no room for more (--frames A:B selects a part)" if self.full else ""
        return sentence + (f"; every {_nth(self.sweeps)} of them has its sweep." if self.sweeps > 1 else ".")


def frame_bytes(taxels: int, resultant_alone: bool = False) -> int:
    """Bytes of a frame: stress and, unless ``resultant_alone``, three forces at every taxel, scales, and values."""
    planes = 1 if resultant_alone else 4
    return planes * (2 * taxels + 4) + 9 * 4 + 2 + 1 + 8


def sweep_bytes(steps: int) -> int:
    """Bytes of a sweep: two values and a bit a candidate, and where it starts."""
    return 8 * (steps + 1) + (steps + 8) // 8 + 4


def _step(count: int, each: int, most: int) -> int:
    return max(1, math.ceil(count / max(1, most // max(1, each))))


def _nth(number: int) -> str:
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number:,}{ending}"
