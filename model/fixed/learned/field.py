"""Normal forces at the taxels (:mod:`tfra.model.learned.field`): the second pass, after the first has been folded."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import butterfly, to_taxels
from tfra.model.fixed.combine import combine
from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.friction import Friction
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.learned.field import MOST_FRICTION


def field(design: Design, still: Ints, sheared: tuple[Ints, Ints], chosen: Friction) -> Ints:
    """p ``(n, m)``, none of it negative, from folded quads ``(n, Q, 4)``.

    ``still`` is -K b, and ``sheared`` are K G_x p and K G_y p of the first pass.
    """
    quads = still
    for scalar, quad in zip((chosen.mu_x, chosen.mu_y), sheared, strict=True):
        quads = combine(design, quads, bounded(design, scalar), quad)
    return to_taxels(design, np.maximum(butterfly(quads), 0))


def bounded(design: Design, scalar: Ints) -> Ints:
    """``scalar (n,)`` limited to the friction that the field may have."""
    most = int(MOST_FRICTION * 2 ** scalar_fraction(design))
    return np.clip(scalar, -most, most)
