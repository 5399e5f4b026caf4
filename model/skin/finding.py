"""Finding the contacts of a frame: the highest peak, its region, and again until no peak is left.

All of it is exact: sums, comparisons and one quotient of integers.  The same code takes codes of the converter, as
the hardware does, and stress in Pa.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntFlag

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Ints
from tfra.model.skin.peaks import peaks
from tfra.model.skin.regions import grown, regions, spans
from tfra.model.skin.smoothing import GAIN, Number, smoothing
from tfra.model.skin.windows import corners, places

THRESHOLD_FRACTION = 8
"""Fraction bits of the threshold in the comparison."""

MOST = 64
"""Largest number of contacts in a frame."""

LARGEST_GAP = 4
"""Most taxels about a region that belong to no other contact."""


MARK_SHIFT = 8
"""Bits of a status below those of ``Mark``."""


class Mark(IntFlag):
    """What is special about a contact; its bits are above those of ``tfra.Status``."""

    EDGE = 1 << MARK_SHIFT
    """The window reaches beyond the array."""
    LARGE = 2 << MARK_SHIFT
    """The region reaches beyond the window."""
    TOUCHING = 4 << MARK_SHIFT
    """The region borders on that of a stronger contact."""


@dataclass(frozen=True, slots=True)
class Finding:
    """How contacts are told apart.

    ``most`` contacts of a frame, the highest first; ``threshold``, the height of the lowest peak over that of the
    frame's highest; ``gap``, how many taxels about a region belong to no other contact.

    Raises ``ValueError`` that starts with the name of what is wrong.
    """

    most: int = 16
    threshold: float = 0.04
    gap: int = 2

    def __post_init__(self) -> None:
        if not 1 <= self.most <= MOST:
            raise ValueError(f"most: 1 to {MOST} is supported, got {self.most}")
        if not (math.isfinite(self.threshold) and 1 <= self.word <= 1 << THRESHOLD_FRACTION):
            raise ValueError(f"threshold: {2.0**-THRESHOLD_FRACTION:.2g} to 1 is supported, got {self.threshold}")
        if not 0 <= self.gap <= LARGEST_GAP:
            raise ValueError(f"gap: 0 to {LARGEST_GAP} is supported, got {self.gap}")

    @property
    def word(self) -> int:
        """The threshold as the comparison has it."""
        return round(self.threshold * (1 << THRESHOLD_FRACTION))


@dataclass(frozen=True, eq=False)
class Found:
    """k contacts in n frames, frame by frame, the highest peak of each first.

    Of shape ``(k,)``: the ``frame``; ``row`` and ``column`` of the region's centroid in taxels with
    ``PLACE_FRACTION`` bits; its number of ``taxels``; ``top`` and ``left``, the first row and column of the window; the
    ``marks``.  ``dropped (n,)``: peaks that are left after as many contacts as there may be.
    """

    frame: Ints
    row: Ints
    column: Ints
    taxels: Ints
    top: Ints
    left: Ints
    marks: Ints
    dropped: Ints

    @property
    def found(self) -> Ints:
        """Contacts of every frame, ``(n,)``."""
        return np.bincount(self.frame, minlength=len(self.dropped))

    @property
    def contact(self) -> Ints:
        """Number of each contact in its frame, from zero, ``(k,)``."""
        count = self.found
        return np.asarray(np.arange(len(self.frame)) - np.repeat(np.cumsum(count) - count, count))


def finding(choices: Finding, window: tuple[int, int], floor: float, frames: npt.NDArray[Number]) -> Found:
    """The contacts in ``frames (n, rows, columns)``, negative under compression, with windows of the shape ``window``.

    A peak below ``floor``, in units of the frames, is none.
    """
    free = np.ones(frames.shape, dtype=np.bool_)
    candidates = _candidates(choices, floor, smooth := smoothing(frames))
    rounds = [np.empty((len(_COLUMNS), 0), dtype=np.int64)]
    for which, region, touching in _rounds(choices, smooth, candidates, free):
        rounds.append(_contacts(which, region, touching, window))
    together = np.concatenate(rounds, axis=1)
    ordered = together[:, np.argsort(together[0], kind="stable")]
    return Found(**dict(zip(_COLUMNS, ordered, strict=True)), dropped=candidates.sum(axis=(1, 2)))


def taken(choices: Finding, floor: float, frames: npt.NDArray[Number]) -> Bools:
    """Which taxels ``(n, rows, columns)`` belong to a contact that is found: its region, and the gap about it."""
    free = np.ones(frames.shape, dtype=np.bool_)
    smooth = smoothing(frames)
    for _ in _rounds(choices, smooth, _candidates(choices, floor, smooth), free):
        pass
    return ~free


def _candidates(choices: Finding, floor: float, smooth: npt.NDArray[Number]) -> Bools:
    """Which taxels are peaks that are high enough."""
    highest = smooth.max(axis=(1, 2), keepdims=True)
    high_enough = smooth * (1 << THRESHOLD_FRACTION) >= highest * choices.word
    return np.asarray(peaks(smooth) & high_enough & (smooth >= floor * GAIN))


def _rounds(
    choices: Finding, smooth: npt.NDArray[Number], candidates: Bools, free: Bools
) -> Iterator[tuple[Ints, Bools, Bools]]:
    """The next contact of every frame that has one: the frames' numbers, regions, and whether others cut them off.

    What it takes is removed from ``candidates`` and ``free (n, rows, columns)``.
    """
    for _ in range(choices.most):
        heights = np.where(candidates, smooth, 0).reshape(len(smooth), -1)
        at = heights.argmax(axis=1)
        height = heights[np.arange(len(at)), at]
        which = np.flatnonzero(height > 0)
        if not len(which):
            return
        high = 2 * smooth[which] >= height[which, None, None]
        region, touching = regions(high, free[which], at[which])
        free[which] &= ~grown(region, choices.gap)
        candidates &= free
        yield which, region, touching


_COLUMNS = ("frame", "row", "column", "taxels", "top", "left", "marks")
"""Fields of :class:`Found` that belong to a contact."""


def _contacts(frame: Ints, region: Bools, touching: Bools, window: tuple[int, int]) -> Ints:
    """One contact of each ``frame``, ``(7, k)`` in the order of ``_COLUMNS``."""
    taxels, place, corner = region.sum(axis=(1, 2)), [], []
    edge = large = np.zeros(len(frame), dtype=np.bool_)
    for span, size, whole in zip(spans(region), window, region.shape[1:], strict=True):
        place.append(places(span.total, taxels))
        corner.append(corners(place[-1], size))
        edge = edge | (corner[-1] < 0) | (corner[-1] + size > whole)
        large = large | (span.first < corner[-1]) | (span.last >= corner[-1] + size)
    marks = Mark.EDGE * edge + Mark.LARGE * large + Mark.TOUCHING * touching
    return np.stack([frame, *place, taxels, *corner, marks])
