"""The compression of a frame, smoothed: a binomial low pass, so that noise makes few peaks."""

from typing import TypeVar

import numpy as np
import numpy.typing as npt

Number = TypeVar("Number", np.int64, np.float32, np.float64)
"""Codes of the converter, or stress in Pa."""

GAIN = 16
"""Sum of the weights."""


def smoothing(frames: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """Weighted sums of the compression about every taxel, ``GAIN`` times its mean, none of them negative.

    In and out ``(n, rows, columns)``; ``frames`` are negative under compression.  The weights are the outer product of
    1 2 1 with itself, and taxels beyond the array count as zero.
    """
    padded = np.pad(frames, ((0, 0), (1, 1), (1, 1)))
    along_x = padded[:, :, :-2] + 2 * padded[:, :, 1:-1] + padded[:, :, 2:]
    compressed: npt.NDArray[Number] = -(along_x[:, :-2] + 2 * along_x[:, 1:-1] + along_x[:, 2:])
    return np.maximum(compressed, 0, out=compressed)
