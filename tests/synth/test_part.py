"""The part that a package is described for."""

from dataclasses import replace

import pytest

from tests.marks import long
from tfra.families import TARGETS
from tfra.model.choices import SERIAL, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.synth.estimate import estimate, part_of

SMALL = TfraDesign(
    SensorArray(3, 4, 4e-3, 2e-3, 3e-3), search=Search(20), architecture=Architecture(4, 1), target="ecp5"
)
MORE_LANES = replace(SMALL, sensor=SensorArray(10, 10, 4e-3, 2e-3, 3e-3), architecture=Architecture(24, 4))

@pytest.mark.parametrize(
    ("design", "name"),
    [
        (SMALL, "ecp5-25-6"),
        # 24 lanes and those of other blocks are more than an ECP5-25 has.
        *long((MORE_LANES, "ecp5-45-6"), (replace(SMALL, architecture=SERIAL, target="portable"), "ecp5-25-6")),
        (replace(SMALL, architecture=SERIAL, target="ice40"), "ice40up5k"),
    ],
)
def test_the_smallest_part_that_a_package_fits(design: Design, name: str) -> None:
    part, target = part_of(design), TARGETS[name]
    assert part.target == target
    total = estimate(design, target.family, package=True).total
    assert all(total[name] >= count for name, count in estimate(design, target.family).total.items())
    assert part.resources == {resource: (total[resource], have) for resource, have in target.available.items()}
    assert target.family.title in part.basis
