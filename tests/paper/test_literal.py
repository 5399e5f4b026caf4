"""The literal loop against the fast model: same results by another road."""

from typing import Any

import numpy as np
import pytest

from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.tfra import Status, Tfra
from tfra.paper.literal import LiteralTfra


def both(name: str, steps: int) -> tuple[list[Any], list[Any]]:
    """Sweep index and forces by the literal loop and by the fast model, of frames that have them."""
    sensor = SENSORS[name]
    stress = frames(sensor, random_contacts(sensor, 60, np.random.default_rng(11)))
    expected = Tfra(sensor, steps)(stress)
    common = expected.status & ~Status.DEPENDENT_OUT_OF_RANGE == 0
    assert common.sum() > 10
    index, forces = expected.sweep_index[common], expected.forces[common].reshape(-1, 3, sensor.taxels)
    return LiteralTfra(sensor, steps)(stress[common]), list(zip(index, forces, strict=True))


def compare(found: list[Any], expected: list[Any]) -> None:
    assert [index for index, _ in found] == [index for index, _ in expected]
    np.testing.assert_allclose([f for _, f in found], [f for _, f in expected], atol=1e-9)


@pytest.mark.parametrize(("name", "steps"), [*zip(list(SENSORS)[:5], (100, 20, 1, 33, 100), strict=True)])
def test_equals_the_fast_model(name: str, steps: int) -> None:
    found, expected = both(name, steps)
    compare(found, expected)
    (index, forces), *rest = found
    for wrong in ((index + 1, forces), (index, forces + 1e-5)):
        with pytest.raises(AssertionError):
            compare([wrong, *rest], expected)
