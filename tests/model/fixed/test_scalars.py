"""Scalars fill their words: [-4, 4) in an operand."""

from fractions import Fraction
from math import floor

import pytest

from tests.model.cases import make_design
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.scalars import mu_grid, scalar_fraction
from tfra.model.fixed.widths import MU_LIMIT


@pytest.mark.parametrize("steps", [1, 7, 100])
@pytest.mark.parametrize("formats", ["standard", "wide"])
def test_the_grid_is_rounded_to_nearest(formats, steps):
    design = make_design(SENSORS["8×8, 2×2 mm, h 3 mm"], formats, steps)
    one = 1 << scalar_fraction(design)
    assert MU_LIMIT * one == 1 << (design.formats.operand - 1)
    assert mu_grid(design).tolist() == [floor(Fraction(k * one, steps) + Fraction(1, 2)) for k in range(steps + 1)]
