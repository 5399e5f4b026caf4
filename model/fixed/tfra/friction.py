"""mu_ind and mu_dep of the chosen candidate (Eqs. 17, 18, 26, 27)."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import round_shift, saturate
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.widths import mu_grid, scalar_fraction


@dataclass(frozen=True)
class Friction:
    """Scalars ``(n,)``; ``index`` is zero and so is every mu where nothing is swept."""

    index: Ints
    mu_ind: Ints
    mu_x: Ints
    mu_y: Ints
    out_of_range: Bools


def friction(design: Design, index: Ints, direction: Direction, affine: Dependent, regular: Bools) -> Friction:
    """Friction of candidate ``index (n,)``; mu_dep saturates, which needs a mu_dep of 4."""
    grid, steps = mu_grid(design), design.search.steps
    mu_ind = np.where(direction.negative, -grid[np.abs(steps - index)], grid[index])
    mu_ind = np.where(regular, mu_ind, 0)
    fraction = scalar_fraction(design)
    mu_dep = saturate(affine.alpha + round_shift(affine.beta * mu_ind, fraction), design.formats.bits("scalar"))
    return Friction(
        np.where(regular, index, 0),
        mu_ind,
        np.where(direction.sweep_y, mu_dep, mu_ind),
        np.where(direction.sweep_y, mu_ind, mu_dep),
        np.abs(mu_dep) > 1 << fraction,
    )
