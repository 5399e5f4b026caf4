"""Pairs of near places: contacts of one frame and the next, or those found and those there are."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from tfra.model.arrays import Floats, Ints
from tfra.model.sensor import SensorArray

APART = 3.0
"""Pitches between a true contact and one that is found, at most."""

DRAGGED = 0.8
"""How far friction of 1 moves the region of a contact, in thicknesses."""


def pairs(ones: Floats, others: Floats, distance: float) -> tuple[Ints, Ints]:
    """Indices ``(p,)`` of ``ones (k, 2)`` and of ``others (q, 2)`` that belong together, less than ``distance`` apart.

    There are as many pairs as possible, and then the sum of their squared distances is the smallest.
    """
    far = np.square(ones[:, None] - others).sum(axis=2)
    near = far < distance**2
    at, to = linear_sum_assignment(np.where(near, far, distance**2 * (1 + min(near.shape))))
    kept = near[at, to]
    return at[kept], to[kept]


def matched(frames: tuple[Ints, Ints], places: tuple[Floats, Floats], distance: float = APART) -> tuple[Ints, Ints]:
    """Indices ``(p,)`` of true contacts and of those found that belong together, frame by frame.

    ``frames (k,)`` and ``places (k, 2)`` of the true ones, and of those found; :func:`seen_at` is where a true one is.
    """
    pairs_of = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    for number in np.union1d(*frames):
        there, here = (np.flatnonzero(frame == number) for frame in frames)
        ones, others = pairs(places[0][there], places[1][here], distance)
        pairs_of.append((there[ones], here[others]))
    true, seen = zip(*pairs_of, strict=True)
    return np.concatenate(true), np.concatenate(seen)


def seen_at(center: Floats, force: Floats, sensor: SensorArray) -> Floats:
    """Where the regions of contacts are, ``(k, 2)`` in pitches, whose ``center (k, 2)`` is in m and ``force`` in N."""
    dragged = center - DRAGGED * sensor.thickness * force[:, :2] / force[:, 2:]
    return np.asarray(dragged / np.array([sensor.pitch_x, sensor.pitch_y]))
