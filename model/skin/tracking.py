"""Tracks: one number for a contact as long as it moves less than a set distance from frame to frame."""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.skin.matching import pairs


class Tracker:
    """Numbers contacts from 0, in the order in which they appear; ``distance`` in m is what none moves in a frame."""

    def __init__(self, distance: float) -> None:
        self._distance = distance
        self._places = np.empty((0, 2))
        self._numbers = np.empty(0, dtype=np.int64)
        self._next = 0

    def __call__(self, places: Floats) -> Ints:
        """The numbers ``(k,)`` of the contacts at ``places (k, 2)``, in m, of the next frame.

        They keep that of their pair in the frame before, :func:`tfra.model.skin.matching.pairs`.
        """
        here, before = pairs(places, self._places, self._distance)
        numbers = np.full(len(places), -1, dtype=np.int64)
        numbers[here] = self._numbers[before]
        fresh = numbers < 0
        numbers[fresh] = self._next + np.arange(fresh.sum())
        self._next += int(fresh.sum())
        self._places, self._numbers = places, numbers
        return numbers


def tracks(found: Ints, places: Floats, distance: float) -> Ints:
    """The numbers ``(k,)`` of contacts at ``places (k, 2)``, ``found (n,)`` of them in each frame."""
    tracker = Tracker(distance)
    each = [tracker(part) for part in np.split(places, np.cumsum(found)[:-1])]
    return np.concatenate(each) if each else np.empty(0, dtype=np.int64)
