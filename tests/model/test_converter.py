"""Codes by the definition: nearest, ends of the range, and what is said of frames beyond it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfra.model.choices import Adc, Architecture, Choices
from tfra.model.converter import convert, quantise, saturated
from tfra.model.sensor import SensorArray

ONE_PASCAL = Adc(bits=8, full_scale=128.0)
CHOICES = Choices(SensorArray(2, 2, 4e-3, 4e-3, 3e-3), adc=ONE_PASCAL, architecture=Architecture(4))


def frame(*values):
    return np.reshape(values, (1, 2, 2))


def test_nearest_code_and_clipping_at_both_ends():
    codes = convert(CHOICES, frame(1.4, -1.6, 126.4, 127.6))
    assert codes.dtype == np.int64
    assert codes.ravel().tolist() == [1, -2, 126, 127]
    assert convert(CHOICES, frame(128, 1e300, -128.4, -1e300)).ravel().tolist() == [127, 127, -128, -128]


def test_quantise_refuses_what_convert_clips():
    within = frame(128.4, -128.4, 0, 0.0)
    np.testing.assert_array_equal(quantise(CHOICES, within), convert(CHOICES, within))
    for beyond in (128.6, -128.6):
        with pytest.raises(ValueError, match=r"frame 0, row 1, column 0 is -?128\.6 Pa, over the full scale of 128 Pa"):
            quantise(CHOICES, frame(0, 0, beyond, 0))
    for function in (quantise, convert):
        with pytest.raises(ValueError, match="row 0, column 1 is not finite"):
            function(CHOICES, frame(0, np.inf, 0, 0))


@given(st.lists(st.integers(-128, 127), min_size=4, max_size=4))
def test_saturated_frames_have_a_code_at_an_end(codes):
    expected = any(code in (-128, 127) for code in codes)
    assert saturated(CHOICES, frame(*codes)).tolist() == [expected]
    assert saturated(CHOICES, np.array([codes])).tolist() == [expected]
