"""Payloads hold what the model's blocks hand on, and no bit more."""

import numpy as np
import pytest

from tests.hdl.parallel.learned.designs import CASES, label
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned import payloads
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.share import share


@pytest.mark.parametrize("design", [*CASES, learned_design(2, 2, lanes=4)], ids=label)
def test_the_longest_shift_has_its_place_and_nothing_is_much_longer(design):
    """The largest sum of p, whose share is a resultant of nothing, or of the least that is not."""
    taxels = design.sensor.taxels
    p = np.full((2, taxels), (1 << (design.widths.force - 1)) - 1)
    assert int(p.sum(axis=1)[0]).bit_length() == total_bits(design, design.widths)
    least = np.array([design.widths.division - 1, design.widths.division - 2])
    found = share(design, Resultant(np.array([[0, 0, 0], [0, 0, -1]]), least), p)
    beyond = payloads.most_shift(design) - found.shift.max()
    assert beyond >= 0
    if design.formats.vector_fraction >= design.formats.force_fraction:
        assert beyond <= 2
