"""Pairs of near places: contacts of one frame and the next, or those found and those there are."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from tfra.model.arrays import Floats, Ints


def pairs(ones: Floats, others: Floats, distance: float) -> tuple[Ints, Ints]:
    """Indices ``(p,)`` of ``ones (k, 2)`` and of ``others (q, 2)`` that belong together, less than ``distance`` apart.

    There are as many pairs as possible, and then the sum of their squared distances is the smallest.
    """
    far = np.square(ones[:, None] - others).sum(axis=2)
    near = far < distance**2
    at, to = linear_sum_assignment(np.where(near, far, distance**2 * (1 + min(near.shape))))
    kept = near[at, to]
    return at[kept], to[kept]
