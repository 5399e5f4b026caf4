"""The dependent friction mu_dep = alpha + beta * mu_ind (Eqs. 12, 17, 18), with cos and sin instead of tan."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import block_normalize, divide, significant_bits
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.tfra import COEFFICIENT_LIMIT


@dataclass(frozen=True)
class Dependent:
    """``alpha``, ``beta (n,)`` as scalars; ``sums (n, 3, 3)``: A_pq of Eq. 12 with a common factor
    ``2^(bits - 1 - significant)``."""

    alpha: Ints
    beta: Ints
    vanishing: Bools
    sums: Ints
    significant: Ints


def gather_sums(sums_b: Ints, sums_n: Ints) -> Ints:
    """A_pq ``(n, 3, 3)`` from the sum quads ``(n, 1, 4)`` and ``(n, 3, 4)`` of the first two stacks."""
    b, n = sums_b, sums_n
    rows = [
        [b[:, 0, OX] + n[:, 0, OX], n[:, 0, EE], n[:, 0, OO]],
        [b[:, 0, OY] + n[:, 0, OY], n[:, 1, OO], n[:, 1, EE]],
        [b[:, 0, EE] + n[:, 2, EE], n[:, 1, OX], n[:, 1, OY]],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1)


def quotients(sums: Ints, direction: Direction) -> Ints:
    """Numerators of alpha and beta, and their denominator, ``(n, 3)``, of ``sums (n, 3, 3)``; exact."""
    cos, sin = direction.cos[:, None], direction.sin[:, None]
    u = sums[:, 0] * sin - sums[:, 1] * cos  # u0, ux, -uy
    num0 = np.where(direction.sweep_y, -u[:, 0], u[:, 0])
    num1 = np.where(direction.sweep_y, -u[:, 2], u[:, 1])
    den = np.where(direction.sweep_y, u[:, 1], -u[:, 2])
    return np.stack([num0, num1, den], axis=1)


def dependent(design: Design, exact: Ints, direction: Direction, regular: Bools) -> Dependent:
    """alpha and beta from ``exact (n, 3, 3)`` sums; zero where the denominator vanishes or nothing is swept."""
    significant = significant_bits(exact, axis=(1, 2))
    a = block_normalize(exact, significant[:, None, None], design.formats.bits("sums"))
    quotient = quotients(a, direction)
    quotient = block_normalize(quotient, significant_bits(quotient, axis=1)[:, None], design.widths.division)
    size = np.abs(quotient)
    vanishing = np.maximum(size[:, 0], size[:, 1]) >= int(COEFFICIENT_LIMIT) * size[:, 2]
    usable = regular & ~vanishing
    safe = np.where(usable, quotient[:, 2], 1)
    alpha, beta = (
        np.where(usable, divide(np.where(usable, quotient[:, i], 0), safe, scalar_fraction(design)), 0)
        for i in (0, 1)
    )
    return Dependent(alpha, beta, vanishing, a, significant)
