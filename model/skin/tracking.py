"""Tracks: one number for a contact as long as it moves less than a set distance from frame to frame."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from tfra.model.arrays import Floats, Ints


class Tracker:
    """Numbers contacts from 0, in the order in which they appear; ``distance`` in m is what none moves in a frame."""

    def __init__(self, distance: float) -> None:
        self._distance = distance
        self._places = np.empty((0, 2))
        self._numbers = np.empty(0, dtype=np.int64)
        self._next = 0

    def __call__(self, places: Floats) -> Ints:
        """The numbers ``(k,)`` of the contacts at ``places (k, 2)``, in m, of the next frame.

        As many as possible keep their number, and then the sum of the squared distances is the smallest.
        """
        far = np.square(places[:, None] - self._places).sum(axis=2)
        near = far < self._distance**2
        here, before = linear_sum_assignment(np.where(near, far, self._distance**2 * (1 + min(near.shape))))
        kept = near[here, before]
        numbers = np.full(len(places), -1, dtype=np.int64)
        numbers[here[kept]] = self._numbers[before[kept]]
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
