"""The folded network against the plain sums over the group of mirrors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.model.learned.plain import mirrored, plain
from tests.model.learned.random_weights import random_weights
from tfra.model.arrays import Floats
from tfra.model.learned.network import Network
from tfra.model.learned.weights import NAMES, Weights
from tfra.model.sensor import SensorArray

SIGNS = np.array([[1, 1, 1, 1], [-1, 1, 1, 1], [1, -1, 1, 1], [-1, -1, 1, 1]])
"""What each mirror does to the outputs."""

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


@given(sizes, sizes, seeds)
@settings(deadline=None, max_examples=30)
def test_the_mirrors_commute_with_it(rows: int, columns: int, seed: int) -> None:
    sensor, rng = array(rows, columns), np.random.default_rng(seed)
    weights, n = random_weights(rng, sensor.taxels, 3, 2), rng.normal(size=(2, sensor.taxels))
    network = Network(sensor, weights)
    for g in range(4):
        difference = network(mirrored(sensor, n, g)) - SIGNS[g] * network(n)
        assert (np.abs(difference) <= 1e-12 * scale(sensor, weights, n)).all()


@given(st.integers(-200, 200), st.floats(1e-3, 1e3), seeds)
@settings(deadline=None, max_examples=30)
def test_the_force_is_proportional(exponent: int, factor: float, seed: int) -> None:
    sensor, rng = array(5, 4), np.random.default_rng(seed)
    weights, n = random_weights(rng, sensor.taxels, 3, 2), rng.normal(size=(2, sensor.taxels))
    network = Network(sensor, weights)
    found = network(n)
    assert np.array_equal(network(np.ldexp(n, exponent)), np.ldexp(found, exponent))
    assert (np.abs(network(factor * n) - factor * found) <= 1e-12 * factor * scale(sensor, weights, n)).all()


@given(arrays(np.float64, (1, 6), elements=st.floats(-1e3, 1e3)))
@settings(deadline=None)
def test_by_hand(n: Floats) -> None:
    """One unit that copies n of taxel (0, 0) where that is positive, read along z and along x."""
    sensor = array(2, 3)
    one = np.zeros((1, 6))
    one[0, 0] = 1.0
    nothing = np.zeros((4, 1, 1))
    read1 = np.array([[2.0], [0.0], [3.0], [-1.0]])
    network = Network(sensor, Weights(one, nothing, np.zeros((4, 1)), read1, np.zeros((4, 6))))
    top = np.maximum(n[0], 0.0)
    left, right = top[0] + top[3], top[2] + top[5]
    assert network(n)[0] == pytest.approx([2 * (left - right), 0.0, 3 * (left + right), -left - right], abs=1e-9)


def test_a_changed_weight_changes_the_force() -> None:
    sensor, rng = array(4, 5), np.random.default_rng(1)
    weights, n = random_weights(rng, 20, 3, 2), rng.normal(size=(50, 20))
    found = Network(sensor, weights)(n)
    for name in NAMES:
        changed = {key: getattr(weights, key).copy() for key in NAMES}
        changed[name].flat[0] += 1e-3
        assert np.abs(Network(sensor, Weights(**changed))(n) - found).max() > 1e-6, name


def test_the_number_of_products() -> None:
    rng = np.random.default_rng(0)
    assert Network(array(10, 10), random_weights(rng, 100, 48, 24)).products == 4800 + 4608 + 4 * (24 + 48 + 25)
    assert Network(array(5, 7), random_weights(rng, 35, 2, 1)).products == 4 * 12 * 2 + 4 * 2 + 4 * (1 + 2 + 12)


def test_weights_of_another_array() -> None:
    with pytest.raises(ValueError, match="first: 20 taxels are needed, got 6"):
        Network(array(4, 5), random_weights(np.random.default_rng(0), 6, 1, 1))
