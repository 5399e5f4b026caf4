"""ReLU at every mirror, between two butterflies: from the results of a product to the operand of the next one."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly


def activation(quads: Ints) -> Ints:
    """Folded units ``(n, units, 4)`` of a layer from its folded sums ``(n, units, 4)``; both on the vector grid."""
    return butterfly(np.maximum(butterfly(quads), 0))
