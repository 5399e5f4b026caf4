"""What follows from a design is made once, stays with it, and does not travel."""

import pickle
from dataclasses import replace

import pytest

from tests.model.cases import make_design
from tfra.model.choices import SERIAL, Architecture
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


@pytest.mark.parametrize("asked", [False, True], ids=["before", "after"])
def test_another_architecture_has_the_same_operators(asked: bool) -> None:
    """Whether they were computed before or not; only then they are the same objects."""
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    if asked:
        assert design.widths
    moved = {"images": "readmemh", "target": "ice40"}
    architectures = SERIAL, Architecture(8, 2)
    found = [design.built_as(each, **moved) for each in architectures]
    for other, architecture in zip(found, architectures, strict=True):
        fresh = replace(design, architecture=architecture, **moved)
        assert other == fresh
        assert (other.widths, other.word_bits) == (fresh.widths, fresh.word_bits)
        assert list(other.stacks) == list(fresh.stacks)
        assert (other.stacks is design.stacks) == asked
    with pytest.raises(ValueError, match="mac_lanes"):
        design.built_as(Architecture(6, 2))


def test_a_pickled_design_has_its_choices_alone() -> None:
    design = TfraDesign(SensorArray(10, 10, 4e-3, 2e-3, 3e-3))
    bare = len(pickle.dumps(design))
    assert design.widths.vector > 0
    packed = pickle.dumps(design)
    assert len(packed) == bare < 1500
    back = pickle.loads(packed)
    assert back == design
    assert repr(back) == repr(design)
    assert back.widths == design.widths
