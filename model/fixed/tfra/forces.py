"""Unscaled forces of the chosen candidate: f = w + A-dagger d (Eqs. 7, 10, 28)."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.combine import combine
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.tfra.friction import Friction
from tfra.model.fixed.widths import force_drop, scalar_fraction


def friction_forces(design: Design, products: Ints, chosen: Friction, n: Ints) -> Ints:
    """Folded forces ``(n, 3, Q, 4)`` from the A-dagger products ``(n, 3 Q, 4)`` and the folded weights."""
    planes = np.split(products, 3, axis=1)
    folded = [combine(design, z, s, n) for z, s in zip(planes, scalars(design, chosen), strict=True)]
    return np.stack(folded, axis=1)


def scalars(design: Design, chosen: Friction) -> tuple[Ints, Ints, Ints]:
    """Factors of the weights of each plane: mu_x, mu_y, -1."""
    return chosen.mu_x, chosen.mu_y, np.full(len(chosen.mu_x), -1 << scalar_fraction(design), dtype=np.int64)


def forces(design: Design, products: Ints, chosen: Friction, n: Ints) -> Ints:
    """Taxel-domain forces ``(n, 3, Q, 4)``; one LSB is ``2^force_drop / 4`` of the vector grid."""
    return round_shift(butterfly(friction_forces(design, products, chosen, n)), force_drop(design))
