"""Direction and friction of single resultants against exact quotients."""

from fractions import Fraction

import numpy as np
import pytest

from tests.model.fixed.learned.cases import learned_design
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.field import bounded
from tfra.model.fixed.learned.friction import angle, friction
from tfra.model.fixed.widths import scalar_fraction

DESIGN = learned_design()
ONE = 1 << (DESIGN.widths.division - 4)
UNIT = 1 << scalar_fraction(DESIGN)
TOP = (1 << (DESIGN.formats.bits("scalar") - 1)) - 1


def total(words: list[list[int]]) -> Resultant:
    return Resultant(np.array(words), np.zeros(len(words), dtype=np.int64))


def test_direction() -> None:
    """A turn has four quarters; without tangential force there is no direction, whatever the normal force is."""
    found = angle(DESIGN, total([[ONE, 0, 5], [0, ONE, 5], [-ONE, 0, 5], [0, -ONE, 5], [0, 0, 5], [0, 0, 0]]))
    quarter = 1 << (iterations(DESIGN) - 2)
    turns = [round(phi / quarter) % 4 for phi in found.phi.tolist()]
    assert turns == [0, 1, 2, 3, 0, 0]
    assert found.phi[4:].tolist() == [0, 0]
    assert found.still.tolist() == [False, False, False, False, True, True]


@pytest.mark.parametrize("normal", [ONE, -ONE, ONE + 1, -3 * ONE])
def test_friction_is_the_quotient_of_the_sizes(normal: int) -> None:
    """mu_x and mu_y round to the nearest scalar; mu has the error of the CORDIC, too."""
    rows = [[x, y, normal] for x in (0, 1, -ONE // 3, 2 * ONE) for y in (0, -1, ONE, -5 * ONE // 4)]
    force = total(rows)
    found = friction(DESIGN, force, angle(DESIGN, force))
    for axis, scalars in enumerate((found.mu_x, found.mu_y)):
        for row, scalar in zip(rows, scalars.tolist(), strict=True):
            assert abs(Fraction(row[axis], abs(normal)) * UNIT - scalar) <= Fraction(1, 2)
    exact = np.hypot(*np.array(rows)[:, :2].T) / abs(normal) * UNIT
    assert np.abs(found.mu - exact).max() < 2 + 4e-4 * UNIT
    assert not found.overflow.any()


def test_friction_that_is_limited() -> None:
    """Four and above, and the last scalar below it; no force has none."""
    rows = [[4 * ONE, -4 * ONE, ONE], [-4 * ONE, 0, -ONE], [4 * ONE - 1, 0, ONE], [0, 0, 0], [1, -1, 0]]
    force = total(rows)
    found = friction(DESIGN, force, angle(DESIGN, force))
    assert found.mu_x.tolist() == [TOP, -TOP, TOP, 0, TOP]
    assert found.mu_y.tolist() == [-TOP, 0, 0, 0, -TOP]
    assert found.mu[[0, 1, 3, 4]].tolist() == [TOP, TOP, 0, TOP]
    assert found.overflow[[0, 1, 3, 4]].tolist() == [True, True, False, True]
    assert TOP == 4 * UNIT - 1


def test_friction_of_the_field_is_limited_to_two() -> None:
    assert bounded(DESIGN, np.array([TOP, -TOP, 2 * UNIT + 1, 2 * UNIT - 1, 0])).tolist() == [
        2 * UNIT, -2 * UNIT, 2 * UNIT, 2 * UNIT - 1, 0,
    ]  # fmt: skip
