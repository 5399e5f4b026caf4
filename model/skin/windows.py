"""The window of a contact: the part of the array about its region that an estimator sees."""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.skin.smoothing import Number

PLACE_FRACTION = 4
"""Fraction bits of a place, in taxels."""


def places(total: Ints, taxels: Ints) -> Ints:
    """Means of indices, ``total / taxels (n,)``, in taxels with ``PLACE_FRACTION`` bits, halves rounded up."""
    return np.asarray(((total << (PLACE_FRACTION + 1)) + taxels) // (2 * taxels))


def corners(place: Ints, size: int) -> Ints:
    """First taxel of a window of ``size`` taxels about each ``place (n,)``; it may lie outside the array."""
    half = 1 << (PLACE_FRACTION - 1)
    return (place + half * (2 - size)) >> PLACE_FRACTION


def windows(
    frames: npt.NDArray[Number], frame: Ints, corner: tuple[Ints, Ints], shape: tuple[int, int]
) -> npt.NDArray[Number]:
    """Windows ``(k, *shape)`` of ``frames (n, rows, columns)``: zero where they reach beyond the array.

    ``frame (k,)`` and the first row and column of each, ``(k,)``, which are off the array by a window at most.
    """
    height, width = shape
    padded = np.pad(frames, ((0, 0), (height, height), (width, width)))
    rows, columns = (first[:, None] + size + np.arange(size) for first, size in zip(corner, shape, strict=True))
    cut: npt.NDArray[Number] = padded[frame[:, None, None], rows[:, :, None], columns[:, None, :]]
    return cut
