"""Resultant of the unscaled forces (Eq. 12), ahead of the forces themselves, from the sums A_pq."""

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.numbers import block_normalize, significant_bits
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import Friction
from tfra.model.fixed.widths import scalar_fraction


def exact_resultant(design: Design, affine: Dependent, chosen: Friction, regular: Bools) -> Ints:
    """F* = A_p0 + mu_x A_p1 + mu_y A_p2, ``(n, 3)``; F_x = F_y = 0 when nothing is swept."""
    a, mu_x, mu_y = affine.sums, chosen.mu_x[:, None], chosen.mu_y[:, None]
    exact = (a[:, :, 0] << scalar_fraction(design)) + a[:, :, 1] * mu_x + a[:, :, 2] * mu_y
    return np.asarray(exact * np.where(regular[:, None], 1, np.array([0, 0, 1])))


def resultant(design: Design, affine: Dependent, chosen: Friction, regular: Bools) -> Resultant:
    """F* normalised together."""
    exact = exact_resultant(design, affine, chosen, regular)
    significant = significant_bits(exact, axis=1)
    bits = design.widths.division
    sums = design.formats.bits("sums")
    exponent = (sums - 1 - affine.significant) + scalar_fraction(design) + (bits - 1 - significant)
    return Resultant(block_normalize(exact, significant[:, None], bits), exponent)
