"""The part that a package is described for."""

from dataclasses import replace

import pytest

from tfra.families import DEFAULT, TARGETS
from tfra.model.choices import SERIAL, Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.estimate import estimate
from tfra.synth.part import part_of

SENSOR = SensorArray(3, 4, 4e-3, 2e-3, 3e-3)
SMALL = TfraDesign(SENSOR, search=Search(20), architecture=Architecture(4, 1), target="ecp5")


def test_the_smallest_part_that_it_fits() -> None:
    part = part_of(SMALL)
    assert part.name == "ecp5-25-6"
    assert part.clock_mhz == TARGETS["ecp5-25-6"].clock_mhz
    total = estimate(SMALL, DEFAULT).total
    assert part.resources == {name: (total[name], have) for name, have in TARGETS[part.name].available.items()}
    assert "ECP5" in part.basis


def test_more_multipliers_take_a_larger_part() -> None:
    """24 lanes and those of other blocks are more than an ECP5-25 has."""
    lanes = replace(SMALL, sensor=SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=Architecture(24, 4))
    assert part_of(lanes).name == "ecp5-45-6"


@pytest.mark.parametrize(("target", "name"), [("ice40", "ice40up5k"), ("portable", "ecp5-25-6")])
def test_families(target: str, name: str) -> None:
    part = part_of(replace(SMALL, architecture=SERIAL, target=target))
    assert part.name == name
    assert set(part.resources) == set(TARGETS[name].available)
