"""Units against plain sums over the mirrors."""

import numpy as np

from tfra.model.fixed.butterfly import HADAMARD
from tfra.model.fixed.learned.activation import activation


def test_mirrors_that_are_not_negative_stay_and_the_others_vanish() -> None:
    """Sums at the mirrors are four times a quad's inverse; each vanishes alone, and zero stays zero."""
    mirrors = np.array([[4, 8, -12, 16], [-4, -8, -12, -16], [0, 0, 0, 0], [1 << 40, -(1 << 40), 0, 4]])
    quads = mirrors @ HADAMARD // 4
    kept = np.array([[4, 8, 0, 16], [0, 0, 0, 0], [0, 0, 0, 0], [1 << 40, 0, 0, 4]])
    assert activation(quads[None]).tolist() == [(kept @ HADAMARD).tolist()]
