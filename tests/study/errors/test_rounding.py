"""Roundings against exact rationals, and in the model against products by hand."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.study.definitions import definition, design
from tfra.model.converter import convert
from tfra.model.fixed.matvec import exact_products
from tfra.study.errors.rounding import RoundedTfra, Rounding, rounded
from tfra.study.frames.block import Part

EXACT = {
    Rounding.HALF_UP: lambda x: math.floor(x + Fraction(1, 2)),
    Rounding.HALF_EVEN: round,
    Rounding.TRUNCATE: math.floor,
}


@pytest.mark.parametrize(
    ("rounding", "expected"),
    [
        (Rounding.HALF_UP, [-2, -1, -1, 0, 0, 1, 1, 2, 2]),
        (Rounding.HALF_EVEN, [-2, -2, -1, 0, 0, 0, 1, 2, 2]),
        (Rounding.TRUNCATE, [-2, -2, -1, -1, 0, 0, 1, 1, 2]),
    ],
)
def test_halves(rounding, expected):
    halves = np.arange(-4, 5)
    assert rounded(halves, np.array(1), rounding).tolist() == expected
    assert rounded(halves, np.array(0), rounding).tolist() == halves.tolist()
    assert rounded(halves, np.array(-2), rounding).tolist() == (4 * halves).tolist()


@given(st.sampled_from(Rounding), st.integers(-(2**50), 2**50), st.integers(-8, 55))
def test_against_rationals(rounding, value, shift):
    exact = EXACT[rounding](Fraction(value) / Fraction(2) ** shift)
    assert rounded(np.array([value]), np.array([shift]), rounding).tolist() == [exact]


def test_half_up_is_the_model_and_the_others_are_not():
    core, block = design(), definition().make(Part.TRAIN, 0)
    codes = convert(core, block.noisy)
    words = {rounding: RoundedTfra(core, rounding).words(codes) for rounding in Rounding}
    assert np.array_equal(words[Rounding.HALF_UP], core.model(codes).words)
    for rounding in (Rounding.HALF_EVEN, Rounding.TRUNCATE):
        assert not np.array_equal(words[rounding], words[Rounding.HALF_UP])


@pytest.mark.parametrize("rounding", Rounding)
def test_products_by_hand(rounding):
    core = design()
    vector = np.random.default_rng(1).integers(-(2**20), 2**20, (2, core.quads, 4))
    found = RoundedTfra(core, rounding).product("residual", vector)
    (sums, shift), *_ = exact_products(core, "residual", vector)
    for frame in range(2):
        for quad in range(sums.shape[1]):
            for parity in range(4):
                exact = Fraction(int(sums[frame, quad, parity])) / Fraction(2) ** int(shift[frame, parity])
                assert found[frame, quad, parity] == EXACT[rounding](exact)
