"""Fixed-point scalars: alpha, beta, mu_x, mu_y, mu are operand-long words in [-4, 4)."""

from __future__ import annotations

import numpy as np

from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints, divide


def scalar_fraction(design: Design) -> int:
    """Fraction bits of a scalar."""
    return design.formats.operand - 3


def mu_grid(design: Design) -> Ints:
    """mu = k / K for k = 0 ... K as scalars, shape ``(K + 1,)``; the negative side is its mirror image."""
    steps = np.arange(design.candidates)
    return divide(steps, np.int64(design.search.steps), scalar_fraction(design))
