"""Fixed-point scalars: alpha, beta, mu_x, mu_y, mu are words in [-4, 4)."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.choices import Choices
from tfra.model.fixed.numbers import divide


def scalar_fraction(choices: Choices) -> int:
    """Fraction bits of a scalar."""
    return choices.formats.bits("scalar") - 3


def mu_grid(choices: Choices) -> Ints:
    """mu = k / K for k = 0 ... K as scalars, shape ``(K + 1,)``; the negative side is its mirror image."""
    steps = np.arange(choices.candidates)
    return divide(steps, np.int64(choices.search.steps), scalar_fraction(choices))
