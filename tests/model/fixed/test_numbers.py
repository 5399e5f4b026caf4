"""Arithmetic primitives against exact rationals and against fxpmath."""

from __future__ import annotations

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from fxpmath import Fxp
from hypothesis import given
from hypothesis import strategies as st

from tfra.model.fixed.numbers import (
    bit_length,
    divide,
    normalise,
    round_shift,
    saturate,
    signed_bits,
    significant_bits,
)

words = st.integers(-(2**40), 2**40)


def half_up(value: Fraction) -> int:
    return floor(value + Fraction(1, 2))


@pytest.mark.parametrize(
    ("value", "shift", "expected"),
    [
        *[(5, 1, 3), (-5, 1, -2), (6, 2, 2), (-6, 2, -1), (-7, 2, -2), (-13, 2, -3), (7, 0, 7), (-3, -2, -12)],
        *[(1, 62, 0), (2**61 - 1, 62, 0), (2**61, 62, 1)],
    ],
)
def test_round_shift_literally(value, shift, expected):
    assert round_shift(value, shift) == expected


@given(words, st.integers(-10, 70))
def test_round_shift_is_exact_rounding(value, shift):
    assert round_shift(value, shift) == half_up(Fraction(value) / Fraction(2) ** shift)


@given(st.integers(-(2**20), 2**20), st.integers(1, 12), st.integers(8, 16))
def test_rounding_and_saturation_agree_with_fxpmath(value, shift, bits):
    """fxpmath with ``around`` rounds ties to even; adding a quarter LSB turns its ties upwards."""
    exact = Fxp(value / 2**shift + 2.0 ** -(shift + 2), True, 40, shift + 2)
    cast = Fxp(exact.get_val(), True, bits, 0, rounding="around", overflow="saturate")
    assert saturate(round_shift(value, shift), bits) == int(cast.val)


def test_saturate_literally():
    assert saturate([-129, -128, 127, 128], 8).tolist() == [-128, -128, 127, 127]


@given(st.integers(0, 2**62 - 1))
def test_bit_length(value):
    assert bit_length(value) == value.bit_length()


@given(st.lists(words, min_size=1, max_size=5))
def test_significant_bits_is_the_shortest_word_less_its_sign(values):
    bits = int(significant_bits(np.array(values), axis=0))
    assert all(-(1 << bits) <= v < 1 << bits for v in values)
    assert bits == 0 or not all(-(1 << (bits - 1)) <= v < 1 << (bits - 1) for v in values)


@given(st.lists(words, min_size=1, max_size=5), st.integers(10, 27))
def test_normalise_fills_the_word(values, bits):
    significant = int(significant_bits(np.array(values), axis=0))
    got = normalise(np.array(values), significant, bits)
    top = 1 << (bits - 1)
    for value, word in zip(values, got.tolist(), strict=True):
        exact = Fraction(value) * Fraction(2) ** (bits - 1 - significant)
        assert word == min(max(half_up(exact), -top), top - 1)
    assert not any(values) or np.abs(got).max() >= top // 2 or set(values) <= {0, -1}


@given(words, words.filter(bool), st.integers(0, 16))
def test_divide(numerator, denominator, fraction):
    exact = Fraction(abs(numerator)) * 2**fraction / abs(denominator)
    sign = -1 if (numerator < 0) != (denominator < 0) else 1
    assert divide(numerator, denominator, fraction) == sign * half_up(exact)


@given(st.integers(0, 2**50))
def test_signed_bits(magnitude):
    bits = signed_bits(magnitude)
    assert magnitude <= (1 << (bits - 1)) - 1
    assert magnitude == 0 or magnitude > (1 << (bits - 2)) - 1
