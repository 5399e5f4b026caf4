"""Peaks of smoothed frames: where a contact may be."""

from itertools import product

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools
from tfra.model.skin.smoothing import Number


def peaks(smooth: npt.NDArray[Number]) -> Bools:
    """Which taxels of ``smooth (n, rows, columns)`` exceed zero and are above or level with all eight neighbours.

    Of level neighbours the first in the order of the taxels is the peak.
    """
    _, rows, columns = smooth.shape
    padded = np.pad(smooth, ((0, 0), (1, 1), (1, 1)))
    result = smooth > 0
    for row, column in product(range(3), repeat=2):
        neighbour = padded[:, row : row + rows, column : column + columns]
        if (row, column) != (1, 1):
            result &= smooth > neighbour if (row, column) < (1, 1) else smooth >= neighbour
    return result
