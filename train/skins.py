"""Held-out errors of a window's network: frames of a skin by the exact series, contacts found as on a skin.

A skin has ``SIDES`` windows a side, so half of the windows reach beyond it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import crowds, nearest
from tfra.model.metrics import errors
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding, Mark, finding
from tfra.model.skin.matching import matched, seen_at
from tfra.model.skin.windows import PLACE_FRACTION, windows
from tfra.train.heldout import BITS, FALSE_ALARMS, LEVELS, NOISES, PERCENTILES, QUIET, TABLE, Estimate, Resultants

SIDES = 3.2

CONTACTS = 8
"""Largest number of contacts in a frame."""

COUNT = 60
"""Frames of each number of contacts."""

SEED, LIMIT_SEED = 30_000, 31_000

FLOOR = 1 / 128
"""Lowest peak over the converter's full scale."""

GAPS = (1.0, 2.0, 3.0, 4.0, np.inf)
"""Limits of the gap to the nearest other contact, in pitches, in the table of errors."""


Simulate = Callable[[SensorArray, Contacts], Floats]
"""The stress ``(k, rows, columns)`` in Pa of each of k contacts."""


class Seen(NamedTuple):
    """Contacts ``(p,)`` that were found, and shares of those there are.

    ``force`` and ``output``: resultants ``(p, 3)``, and outputs ``(p, 4)`` of the network; ``gap`` to the nearest other
    contact in pitches, infinite for a single one; ``edges`` that the window reaches beyond.
    """

    force: Floats
    output: Floats
    gap: Floats
    edge: Ints
    missed: float
    invented: float


@dataclass(frozen=True, eq=False)
class Crowd:
    """Exact frames ``(n, rows, columns)`` in Pa of known contacts, of which ``frame (k,)`` has the numbers."""

    sensor: SensorArray
    frame: Ints
    center: Floats
    force: Floats
    gap: Floats
    exact: Floats

    @classmethod
    def of(
        cls,
        window: SensorArray,
        counts: Ints,
        seed: int,
        gap: float = 2.0,
        ratio: float = 5.0,
        *,
        sides: float = SIDES,
        simulate: Simulate = frames,
    ) -> "Crowd":
        """Random frames with ``counts (n,)`` contacts each on a skin of ``sides`` windows a side."""
        rng = np.random.default_rng(seed)
        sensor = replace(window, rows=int(sides * window.rows), columns=int(sides * window.columns))
        contacts, frame = crowds(sensor, counts, rng, gap, ratio)
        exact = np.zeros((len(counts), sensor.rows, sensor.columns))
        np.add.at(exact, frame, simulate(sensor, contacts))
        return cls(sensor, frame, contacts.center, contacts.force, nearest(contacts, frame, sensor), exact)

    def see(self, window: SensorArray, estimate: Estimate, level: float) -> Seen:
        """What is found in the frames with noise of ``level`` over each one's peak, as the converter reads them."""
        rng = np.random.default_rng(SEED)
        peak = np.abs(self.exact).max(axis=(1, 2), keepdims=True)
        full = peak / rng.uniform(*LEVELS, (len(peak), 1, 1))
        noisy = self.exact + level * peak * rng.normal(size=self.exact.shape)
        codes = np.rint(noisy / full * 2 ** (BITS - 1)).astype(np.int64)
        found = finding(Finding(CONTACTS), (window.rows, window.columns), FLOOR * 2 ** (BITS - 1), codes)
        cut = windows(codes, found.frame, (found.top, found.left), (window.rows, window.columns))
        step = (full[found.frame] / 2 ** (BITS - 1)).reshape(-1, 1)
        output = estimate(cut.reshape(len(cut), -1) * step * window.taxel_area)
        places = np.stack([found.column, found.row], axis=1) / (1 << PLACE_FRACTION)
        there = seen_at(self.center, self.force, self.sensor)
        true, seen = matched((self.frame, found.frame), (there, places))
        edge = (found.marks[seen] & Mark.EDGE) != 0
        count = len(self.frame)
        missed, invented = 1 - len(true) / count, (len(found.frame) - len(seen)) / count
        return Seen(self.force[true], output[seen], self.gap[true], edge, missed, invented)


def held_out(window: SensorArray, estimate: Estimate, count: int = COUNT) -> dict[str, float]:
    """Return median and 95th percentile of every error of ``TABLE``, named like ``mu_95_at_0.001``.

    At 0.1 % noise they are there by gap, ``mu_95_gap_2_3``, and at the edge; ``missed`` and ``invented`` are shares.
    """
    counts = np.repeat(np.arange(1, CONTACTS + 1), count)
    crowd = Crowd.of(window, counts, SEED)
    summary: dict[str, float] = {}
    for level in NOISES:
        seen = crowd.see(window, estimate, level)
        summary |= {f"missed_at_{level:g}": seen.missed, f"invented_at_{level:g}": seen.invented}
        summary |= errors_of(seen, f"at_{level:g}")
    seen = crowd.see(window, estimate, QUIET)
    for low, high in pairwise(GAPS[1:]):
        summary |= errors_of(seen, f"gap_{low:g}_{high:g}", (seen.gap >= low) & (seen.gap < high))
    summary |= errors_of(seen, "alone", seen.gap == np.inf)
    summary |= errors_of(seen, "inside", seen.edge == 0) | errors_of(seen, "edge", seen.edge == 1)
    close = Crowd.of(window, counts, SEED + 1, gap=GAPS[0]).see(window, estimate, QUIET)
    summary |= errors_of(close, f"gap_{GAPS[0]:g}_{GAPS[1]:g}", close.gap < GAPS[1])
    summary |= errors_of(Crowd.of(window, counts, SEED + 2, ratio=10.0).see(window, estimate, QUIET), "ratio_10")
    return summary


def errors_of(seen: Seen, name: str, which: Bools | slice = slice(None)) -> dict[str, float]:
    """Percentiles of every error of the contacts ``which`` were seen."""
    every = errors(Resultants(seen.force[which]), Resultants(seen.output[which, :3]))
    return {
        f"{key}_{share}_{name}": float(np.percentile(every[error], share))
        for key, error in TABLE.items()
        for share in PERCENTILES
    }


def threshold(window: SensorArray, estimate: Estimate, count: int = 2000) -> float:
    """Return the uncertainty over |F_z| that ``FALSE_ALARMS`` of quiet single contacts exceed."""
    output = Crowd.of(window, np.ones(count, dtype=np.int64), LIMIT_SEED).see(window, estimate, QUIET).output
    return float(np.quantile(output[:, 3] / np.abs(output[:, 2]), 1 - FALSE_ALARMS))
