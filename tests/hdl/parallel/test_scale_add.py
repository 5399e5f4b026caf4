"""ScaleAdd against exact fractions, rounded once to an operand and once to the grid of z."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest

from tests.hdl.parallel.designs import VECTORS, label, random_words
from tfra.hdl.parallel.scale_add import ScaleAdd, Stage
from tfra.model.fixed.widths import scalar_fraction
from tfra.sim.harness import play

BEATS = 300


def _half_up(value):
    return floor(value + Fraction(1, 2))


def _product(design, x, headroom, scalar):
    """``scalar * x`` in units of z, x as a multiplier operand."""
    operand, vector = design.formats.operand, design.widths.vector
    unit = Fraction(2) ** (vector - operand - headroom)  # of the operand, in units of x
    word = min(_half_up(x / unit), (1 << (operand - 1)) - 1)
    return word * unit * scalar / 2 ** scalar_fraction(design)


def _beat(design, rng):
    """Words and scalar whose sums fit a vector; headroom is any that x has, as of a parity with longer words."""
    bits, size = design.widths.vector, design.architecture.vector_words
    limit = 1 << (bits - 2)
    while True:
        x = random_words(rng, bits, (size,)).tolist()
        scalar = int(random_words(rng, design.formats.operand, ()))
        free = [bits - 1 - (word if word >= 0 else ~word).bit_length() for word in x]
        headroom = [int(rng.choice([most, rng.integers(0, most, endpoint=True)])) for most in free]
        added = [_product(design, *pair, scalar) for pair in zip(x, headroom, strict=True)]
        if all(abs(value) < limit for value in added):
            return x, headroom, scalar, random_words(rng, bits - 1, (size,)).tolist(), added


@pytest.mark.parametrize("design", VECTORS, ids=label)
def test_rounds_the_exact_sum_half_up(design):
    rng = np.random.default_rng(8)
    rows = [_beat(design, rng) for _ in range(BEATS)]
    cycles = [{} for _ in range(BEATS + Stage.SUM + 1)]
    for number, (x, headroom, scalar, z, _) in enumerate(rows):
        cycles[number + Stage.X_CHOSEN] |= {"x": x, "headroom": headroom}
        cycles[number + Stage.ROUNDED] |= {"scalar": scalar}
        cycles[number + Stage.Z] |= {"z": z}
    seen = play(ScaleAdd(design, design.architecture.vector_words, design.widths.vector), cycles, ["sum"])
    for number, (_, _, _, z, added) in enumerate(rows):
        expected = [base + _half_up(value) for base, value in zip(z, added, strict=True)]
        assert seen[number + Stage.SUM]["sum"] == expected, f"beat {number}"
