"""Ways to round a product's exact sum to the vector grid, tried in the model alone.

The format of the project is half up everywhere (:mod:`tfra.model.fixed.numbers`).  Only the results of the lanes leave
the hardware a choice: each is rounded once, by an adder after the shift.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import exact_products
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.tfra.pipeline import FixedTfra


class Rounding(StrEnum):
    """Treatment of the bits that are shifted out."""

    HALF_UP = "half_up"
    HALF_EVEN = "half_even"
    TRUNCATE = "truncate"
    """Towards minus infinity: bits are cut off."""


def rounded(value: Ints, shift: Ints, rounding: Rounding) -> Ints:
    """``value / 2^shift`` as an integer; negative shifts multiply.  Shapes broadcast."""
    if rounding is Rounding.HALF_UP:
        return round_shift(value, shift)
    right = np.clip(shift, 0, 62)
    down, rest = value >> right, value & ((np.int64(1) << right) - 1)
    if rounding is Rounding.HALF_EVEN:
        half = (np.int64(1) << right) >> 1  # none where nothing is shifted out
        down = down + ((rest > half) | ((rest == half) & (half > 0) & (down & 1 == 1)))
    return np.asarray(down << np.clip(-shift, 0, 62), dtype=np.int64)


class RoundedTfra(FixedTfra):
    """The bit-accurate model with another rounding of its products' results."""

    def __init__(self, design: Design, rounding: Rounding) -> None:
        super().__init__(design)
        self._rounding = rounding

    def product(self, stack: str, vector: Ints) -> Ints:
        """Result quads, rounded as chosen."""
        exact = exact_products(self.design, stack, vector)
        return np.concatenate([rounded(sums, shift[:, None], self._rounding) for sums, shift in exact], axis=1)
