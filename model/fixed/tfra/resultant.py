"""Resultant of the unscaled forces (Eq. 12), ahead of the forces themselves, from the sums A_pq."""

from __future__ import annotations

import numpy as np

from tfra.model.arrays import Bools
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.numbers import normalise, significant_bits
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import Friction


def resultant(design: Design, affine: Dependent, chosen: Friction, regular: Bools) -> Resultant:
    """F* = A_p0 + mu_x A_p1 + mu_y A_p2, exact, then normalised together; F_x = F_y = 0 when nothing is swept."""
    a, fraction = affine.sums, scalar_fraction(design)
    exact = (a[:, :, 0] << fraction) + a[:, :, 1] * chosen.mu_x[:, None] + a[:, :, 2] * chosen.mu_y[:, None]
    exact = exact * np.where(regular[:, None], 1, np.array([0, 0, 1]))
    significant = significant_bits(exact, axis=1)
    bits = design.widths.division
    exponent = (design.formats.bits("sums") - 1 - affine.significant) + fraction + (bits - 1 - significant)
    return Resultant(normalise(exact, significant[:, None], bits), exponent)
