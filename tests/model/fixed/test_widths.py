"""Word lengths are as long as inputs can make words, and bounds hold for the inputs that come closest to them."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest

from tests.model.cases import make_design
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.coefficients import Folding
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.tfra.dependent import gather_sums
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.widths import MU_LIMIT, mu_grid, scalar_fraction
from tfra.model.sensor import SensorArray

COARSE = {
    "10×10, 20×20 mm, h 1 mm": SensorArray(10, 10, 20e-3, 20e-3, 1e-3),
    "3×8, 12×12 mm, h 1 mm": SensorArray(3, 8, 12e-3, 12e-3, 1e-3),
}
"""Taxels far apart: each is alone, so that sums over all of them are the longest words."""


def largest(values):
    return float(np.abs(values).max())


def signs_of_rows(design, names):
    """Codes ``(n, rows, columns)`` that are extreme with the signs of a row of an operator, and the reverse."""
    rows = [Folding(design).taxel_matrix(op) for s in design.stacks.values() for op in s.operators if op.name in names]
    top = (1 << (design.adc.bits - 1)) - 1
    up = np.where(np.concatenate(rows) < 0, -top - 1, top)
    return np.concatenate([up, ~up]).reshape(-1, design.sensor.rows, design.sensor.columns)


@pytest.mark.parametrize("name", COARSE)
def test_sums_are_the_longest_words_of_a_coarse_array(name):
    """Both parts of a sum, and their total, which ``dependent`` adds up modulo the word.

    They are added up as if both could be largest at once; that costs a bit at most.
    """
    design = make_design(COARSE[name])
    vector, signs = design.widths.vector, signs_of_rows(design, {"c33_inv"})
    top = (1 << (design.adc.bits - 1)) - 1
    flat = np.array([top, -top - 1])[:, None, None] * np.ones(signs.shape[1:], np.int64)
    products = FixedTfra(design)(np.concatenate([flat, signs])).stages["matvec"]
    contact = sum(op.quads for op in design.stacks["contact"].operators)
    residual = contact + sum(op.quads for op in design.stacks["residual"].operators)
    parts = [
        design.stacks[stack].split(products[:, start:end])[sums]
        for stack, sums, start, end in (("contact", "sums_b", 0, contact), ("residual", "sums_n", contact, residual))
    ]
    full, (_, sums_b) = top + 1 << design.formats.vector_fraction, design.stacks["contact"].operators
    assert 0.99 * sums_b.gain * full < largest(parts[0]) <= sums_b.gain * full + 2
    for words in (*parts, gather_sums(*parts)):
        assert signed_bits(largest(words)) <= vector
    assert largest(gather_sums(*parts)) == largest(products)
    assert signed_bits(largest(products)) >= vector - 1


@pytest.mark.parametrize("name", SENSORS)
def test_products_reach_their_bounds(name):
    """C33⁻¹ b of codes with the signs of its rows: the bound allows for roundings alone."""
    design = make_design(SENSORS[name])
    op = design.stacks["contact"].operators[0]
    frames = signs_of_rows(design, {"c33_inv"})
    found = design.stacks["contact"].split(FixedTfra(design)(frames).stages["matvec"][:, : design.quads + 1])["c33_inv"]
    full = 1 << (design.adc.bits - 1 + design.formats.vector_fraction)
    unfolded = largest(found @ np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1], [1, -1, -1, 1]])) / 4
    assert 0.98 * op.gain * full < unfolded <= op.gain * full + 2


@pytest.mark.parametrize("steps", [1, 7, 100])
@pytest.mark.parametrize("formats", ["standard", "wide"])
def test_the_grid_is_rounded_to_nearest(formats, steps):
    design = make_design(SENSORS["8×8, 2×2 mm, h 3 mm"], formats, steps)
    one = 1 << scalar_fraction(design)
    assert MU_LIMIT * one == 1 << (design.formats.operand - 1)
    assert mu_grid(design).tolist() == [floor(Fraction(k * one, steps) + Fraction(1, 2)) for k in range(steps + 1)]
