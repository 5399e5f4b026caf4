"""The literal loop against the fast model: same results by another road."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.tfra import Result, Status, Tfra
from tfra.paper.literal import LiteralTfra


def assert_same(found: Result, expected: Result) -> None:
    for name in ("status", "sweep_index"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    for name in ("forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-9, err_msg=name)


@pytest.mark.parametrize(("name", "steps"), [*zip(list(SENSORS)[:5], (100, 20, 1, 33, 100), strict=True)])
def test_equals_the_fast_model(name: str, steps: int) -> None:
    sensor = SENSORS[name]
    stress = frames(sensor, random_contacts(sensor, 60, np.random.default_rng(11)))
    expected = Tfra(sensor, steps)(stress)
    common = expected.status & ~(Status.COMPRESSION_ONLY | Status.DEPENDENT_OUT_OF_RANGE) == 0
    assert common.sum() > 30
    assert_same(LiteralTfra(sensor, steps)(stress[common]), Tfra(sensor, steps)(stress[common]))


def test_frames_without_a_sweep() -> None:
    sensor = SENSORS["4×6, 5×3 mm, h 2 mm"]
    stress = np.stack([np.ones((4, 6)), -np.arange(24.0).reshape(4, 6), np.zeros((4, 6))])
    assert_same(LiteralTfra(sensor)(stress), Tfra(sensor)(stress))
    assert LiteralTfra(sensor)(stress[:0]).forces.shape == (0, 3, 4, 6)


@pytest.mark.parametrize("name", ["forces", "resultant", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"])
def test_the_comparison_notices_one_wrong_value(name: str) -> None:
    sensor = SENSORS["5×7, 3×3 mm, h 2 mm"]
    result = Tfra(sensor)(frames(sensor, random_contacts(sensor, 3, np.random.default_rng(2))))
    wrong = getattr(result, name).copy()
    wrong.flat[-1] += 1 if wrong.dtype == np.int64 else 1e-5
    with pytest.raises(AssertionError):
        assert_same(replace(result, **{name: wrong}), result)


def test_bad_arguments() -> None:
    sensor = SENSORS["4×6, 5×3 mm, h 2 mm"]
    with pytest.raises(ValueError, match="steps: at least 1 is needed, got 0"):
        LiteralTfra(sensor, 0)
    with pytest.raises(ValueError, match="frames: shape"):
        LiteralTfra(sensor)(np.zeros((4, 6)))
