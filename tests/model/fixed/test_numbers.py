"""Arithmetic primitives against exact rationals and against fxpmath."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from fxpmath import Fxp
from hypothesis import given
from hypothesis import strategies as st

from tfra.model.fixed.numbers import (
    bit_length,
    block_normalize,
    divide,
    fit,
    round_shift,
    saturate,
    signed_bits,
    significant_bits,
)
from tfra.model.rounding import Overflow, Rounding

words = st.integers(-(2**40), 2**40)


def half_up(value: Fraction) -> int:
    return floor(value + Fraction(1, 2))


EXACT = {Rounding.HALF_UP: half_up, Rounding.HALF_EVEN: round, Rounding.TRUNCATE: floor}
"""The definitions, with exact rationals."""


@pytest.mark.parametrize(
    ("rounding", "halves"),
    [
        (Rounding.HALF_UP, [-2, -1, -1, 0, 0, 1, 1, 2, 2]),
        (Rounding.HALF_EVEN, [-2, -2, -1, 0, 0, 0, 1, 2, 2]),
        (Rounding.TRUNCATE, [-2, -2, -1, -1, 0, 0, 1, 1, 2]),
    ],
)
def test_round_shift_literally(rounding, halves):
    values = np.arange(-4, 5)
    assert round_shift(values, 1, rounding).tolist() == halves
    assert round_shift(values, 0, rounding).tolist() == values.tolist()
    assert round_shift(values, -2, rounding).tolist() == (4 * values).tolist()
    assert round_shift([2**61 - 1, 2**61], 62, rounding).tolist() == [0, int(rounding is Rounding.HALF_UP)]


@given(st.sampled_from(Rounding), words, st.integers(-10, 70))
def test_round_shift_is_exact_rounding(rounding, value, shift):
    assert round_shift(value, shift, rounding) == EXACT[rounding](Fraction(value) / Fraction(2) ** shift)


@given(st.sampled_from(Rounding), words, st.integers(0, 40))
def test_what_rounds_is_a_constant_or_refused(rounding, value, drop):
    if rounding.sticky:
        with pytest.raises(ValueError, match=r"^rounding: half_even adds no constant$"):
            rounding.constant(drop)
    else:
        assert (value + rounding.constant(drop)) >> drop == round_shift(value, drop, rounding)


def test_saturate_literally():
    assert saturate([-129, -128, 127, 128], 8).tolist() == [-128, -128, 127, 127]


@given(st.sampled_from(Overflow), words, st.integers(8, 16))
def test_overflow_agrees_with_fxpmath(overflow, value, bits):
    if overflow is Overflow.NEVER:
        assert fit(value, bits, overflow) == value
        return
    signed = overflow is Overflow.SATURATE
    assert fit(value, bits, overflow) == int(Fxp(value, signed, bits, 0, overflow=str(overflow)).val)


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
    got = block_normalize(np.array(values), significant, bits)
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
