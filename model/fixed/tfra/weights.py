"""w_z of Eq. 9: the compressive part of C33^-1 b, as n = -w_z >= 0."""

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.numbers import round_shift


def weights(solution: Ints, regular: Bools) -> Ints:
    """Folded n ``(n, Q, 4)`` from the folded C33^-1 b; frames that are not swept keep it unclipped."""
    n = -round_shift(butterfly(solution), 2)
    return butterfly(np.where(regular[:, None, None], np.maximum(n, 0), n))
