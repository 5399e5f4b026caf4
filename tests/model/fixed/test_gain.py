"""The gain of frames that are not scaled, against its definition."""

from fractions import Fraction

import pytest

from tests.model.cases import make_design
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.gain import normal_gain


@pytest.mark.parametrize("formats", ["standard", "wide"])
@pytest.mark.parametrize("name", SENSORS)
def test_the_normal_gain_fills_its_word(name, formats):
    """h^2 over a taxel's area, in steps of the vector grid, to the last of an operand's bits."""
    design = make_design(SENSORS[name], formats)
    sensor, bits = design.sensor, design.formats.operand
    exact = Fraction(sensor.thickness) ** 2 / Fraction(sensor.taxel_area) / 2**design.formats.vector_fraction
    mantissa, exponent = normal_gain(design)
    assert 1 << (bits - 1) <= mantissa < 1 << bits
    assert abs(mantissa - exact * 2**exponent) <= Fraction(1, 2) + Fraction(1, 1 << 20)
