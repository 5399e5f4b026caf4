"""The folded network against the plain sums over the group of mirrors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.learned.plain import plain
from tests.model.learned.random_weights import random_weights
from tfra.model.arrays import Floats
from tfra.model.learned.network import NAMES, Network, Weights
from tfra.model.sensor import SensorArray

GOOD = random_weights(np.random.default_rng(0), 6, 3, 2)
sizes = st.integers(2, 9)
seeds = st.integers(0, 2**32 - 1)


def array(rows: int, columns: int) -> SensorArray:
    return SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)


def scale(sensor: SensorArray, weights: Weights, n: Floats) -> Floats:
    """The sum of the magnitudes of all terms of F: what rounding is relative to, ``(frames, 1)``."""
    signless = Weights(**{name: np.abs(getattr(weights, name)) for name in NAMES})
    return np.abs(plain(sensor, signless, np.abs(n), signed=False)).max(axis=1, keepdims=True)


@given(sizes, sizes, st.integers(1, 5), st.integers(1, 5), seeds)
@settings(deadline=None, max_examples=60)
def test_both_forms_agree(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    sensor, rng = array(rows, columns), np.random.default_rng(seed)
    weights, n = random_weights(rng, sensor.taxels, c1, c2), rng.normal(size=(3, sensor.taxels))
    difference = np.abs(Network(sensor, weights)(n) - plain(sensor, weights, n))
    assert (difference <= 1e-12 * scale(sensor, weights, n)).all()


def test_the_number_of_products() -> None:
    rng = np.random.default_rng(0)
    assert Network(array(10, 10), random_weights(rng, 100, 48, 24)).products == 4800 + 4608 + 4 * (24 + 48 + 25)
    assert Network(array(5, 7), random_weights(rng, 35, 2, 1)).products == 4 * 12 * 2 + 4 * 2 + 4 * (1 + 2 + 12)


def test_weights_of_another_array() -> None:
    with pytest.raises(ValueError, match="first: 20 taxels are needed, got 6"):
        Network(array(4, 5), random_weights(np.random.default_rng(0), 6, 1, 1))


def test_counts() -> None:
    assert GOOD.counts == (3, 2)
    assert GOOD.taxels == 6
    assert all(getattr(GOOD, name).dtype == np.float64 for name in NAMES)


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("first", (3,)),
        ("first", (0, 6)),
        ("second", (2, 3)),
        ("second", (3, 2, 3)),
        ("second", (4, 2, 4)),
        ("read2", (4, 3)),
        ("read1", (3, 3)),
        ("direct", (4, 5)),
    ],
)
def test_another_shape(name: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        Weights(**{key: np.zeros(shape) if key == name else getattr(GOOD, key) for key in NAMES})


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(name: str, value: float) -> None:
    arrays = {key: getattr(GOOD, key).copy() for key in NAMES}
    arrays[name].flat[-1] = value
    with pytest.raises(ValueError, match=f"^{name}: a number is not finite"):
        Weights(**arrays)
