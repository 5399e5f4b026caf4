"""What is advised fits, and the next value does not."""

from dataclasses import replace

import pytest

from tfra.model.choices import FORMATS
from tfra.model.fixed.advice import advice, fits
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DENSE = TfraDesign(SensorArray(10, 10, 1e-3, 1e-3, 3e-3))
"""A pitch of a third of the cover's thickness."""


def with_fraction(bits: int) -> TfraDesign:
    return replace(DENSE, formats=replace(DENSE.formats, name="custom", vector_fraction=bits))


def test_a_dense_array() -> None:
    assert not fits(DENSE)
    assert advice(DENSE) == "formats.vector_fraction_bits = 3 or sensor.thickness_mm = 2.88"
    assert fits(with_fraction(3))
    assert not fits(with_fraction(4))
    assert fits(replace(DENSE, sensor=replace(DENSE.sensor, thickness=2.88e-3)))


@pytest.mark.parametrize("name", FORMATS)
def test_what_fits_needs_no_advice(name: str) -> None:
    assert fits(TfraDesign(SensorArray(6, 8, 3e-3, 2e-3, 2e-3), formats=FORMATS[name]))


def test_sometimes_nothing_helps() -> None:
    """A cover ten times as thick as the pitch."""
    assert advice(replace(DENSE, sensor=replace(DENSE.sensor, thickness=20e-3))) == ""
