"""ScaleAdd against exact fractions, rounded once to an operand and once to the grid of z."""

import random
from fractions import Fraction
from math import floor

import pytest

from tests.hdl.parallel.designs import label
from tests.hdl.parallel.tfra.combine.designs import DESIGNS, words
from tfra.hdl.parallel.scale_add import ScaleAdd, Stage
from tfra.model.fixed.scalars import scalar_fraction
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
        x, (scalar,) = words(rng, bits, size), words(rng, design.formats.operand, 1)
        free = [bits - 1 - (word if word >= 0 else ~word).bit_length() for word in x]
        headroom = [rng.choice([most, rng.randint(0, most)]) for most in free]
        added = [_product(design, *pair, scalar) for pair in zip(x, headroom, strict=True)]
        if all(abs(value) < limit for value in added):
            return x, headroom, scalar, words(rng, bits - 1, size), added


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_rounds_the_exact_sum_half_up(design):
    rng = random.Random(8)
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


def test_ties_and_saturation_are_among_them():
    """Corners that a wrong rounding would fail: exact halves, and an operand that rounds up to a power of two."""
    design, rng = DESIGNS[0], random.Random(8)
    rows = [_beat(design, rng) for _ in range(BEATS)]
    assert any(value.denominator == 2 for *_, added in rows for value in added)
    top = (1 << (design.widths.vector - 1)) - 1
    unit = Fraction(2) ** (design.widths.vector - design.formats.operand)
    pairs = [pair for x, headroom, *_ in rows for pair in zip(x, headroom, strict=True)]
    assert any(_half_up((word << free) / unit) * unit > top for word, free in pairs)
