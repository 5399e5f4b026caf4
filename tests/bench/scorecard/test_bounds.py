"""Line 9: a bound that is exceeded, or too large, misses the target."""

import numpy as np
import pytest

from bench.scorecard import bounds
from bench.scorecard.words.harness import Configuration
from tfra.model.choices import Adc, Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.study.bounds.tfra import TfraBounds

SMALL = Configuration(
    "small",
    TfraDesign(SensorArray(2, 2, 4e-3, 2e-3, 3e-3), "c", adc=Adc(8), search=Search(4), architecture=Architecture(4)),
)


@pytest.mark.parametrize(
    ("factor", "passed", "exceeding"), [(1.0, True, False), (0.5, False, True), (20.0, False, False)]
)
def test_bounds_that_are_wrong_miss_the_target(factor, passed, exceeding, monkeypatch):
    right = TfraBounds.bounds
    monkeypatch.setattr(bounds, "configurations", lambda quick: [SMALL])
    monkeypatch.setattr(bounds, "QUICK_ROUNDS", 10)
    monkeypatch.setattr(TfraBounds, "bounds", lambda self, of: {k: factor * v for k, v in right(self, of).items()})
    found = bounds.measure(True)
    assert found.passed is passed
    assert (found.facts["exceeding"] > 0) is exceeding
    assert found.facts["errors"] > 1000


def test_changed_frames_stay_in_the_range_of_the_converter():
    design = SMALL.design
    codes = np.zeros((50, design.sensor.taxels), dtype=np.int64)
    found = bounds.changed(design, codes, np.random.default_rng(1))
    assert found.min() == -128
    assert found.max() == 127
