"""What follows from a design is made once, stays with it, and does not travel."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from tests.model.cases import make_design
from tfra.model.choices import FORMATS, Search
from tfra.model.cover.scenes import SENSORS
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


def test_everything_is_made_once() -> None:
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    first = design.stacks, design.widths, design.layout
    others = [replace(design, search=Search(steps)).widths for steps in range(1, 60)]
    assert len({widths.candidate for widths in others}) > 1
    assert all(a is b for a, b in zip(first, (design.stacks, design.widths, design.layout), strict=True))


def test_other_choices_have_other_consequences() -> None:
    design = make_design(SENSORS["4×6, 5×3 mm, h 2 mm"])
    wide = replace(design, formats=FORMATS["wide"])
    assert isinstance(wide, TfraDesign)
    assert wide.widths.vector > design.widths.vector
    assert wide.word_bits > design.word_bits
    assert wide != design


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


def test_a_design_is_of_an_estimator() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Design(SensorArray(2, 2, 4e-3, 4e-3, 3e-3))
