"""Unscaled forces of the chosen candidate: f = w + A-dagger d (Eqs. 7, 10, 28)."""

from __future__ import annotations

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.tfra.combine import combine
from tfra.model.fixed.tfra.friction import Friction
from tfra.model.fixed.widths import force_drop


def forces(design: Design, products: Ints, chosen: Friction, n: Ints) -> Ints:
    """Taxel-domain forces ``(n, 3, Q, 4)`` from the A-dagger products ``(n, 3 Q, 4)`` and the folded weights.

    One LSB is ``2^force_drop / 4`` of the vector grid.
    """
    minus_one = np.full(len(n), -1 << scalar_fraction(design), dtype=np.int64)
    planes = np.split(products, 3, axis=1)
    scalars = (chosen.mu_x, chosen.mu_y, minus_one)
    folded = [combine(design, z, s, n) for z, s in zip(planes, scalars, strict=True)]
    return round_shift(butterfly(np.stack(folded, axis=1)), force_drop(design))
