"""The dense network against the plain definition, and its gradient against differences of the loss."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.learned.plain import plain
from tfra.model.learned.weights import NAMES
from tfra.model.sensor import SensorArray
from tfra.train.augment import augmented
from tfra.train.network import DOUBT, SMOOTH, Dense, Shape, loss_and_gradient, outputs


def case(rows: int, columns: int, counts: tuple[int, int], seed: int) -> tuple[SensorArray, Shape, np.ndarray]:
    sensor = SensorArray(rows, columns, 1.0, 1.0, 1.0)
    shape = Shape.of(sensor, counts)
    return sensor, shape, np.random.default_rng(seed).normal(size=shape.length)  # doubles, for differences


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 6), st.integers(2, 6), st.integers(1, 4), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_the_dense_network_is_the_network(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    sensor, shape, vector = case(rows, columns, (c1, c2), seed)
    n = np.random.default_rng(seed).normal(size=(5, sensor.taxels))
    weights = shape.weights(vector)
    np.testing.assert_allclose(outputs(shape.spread(vector), n), plain(sensor, weights, n), rtol=1e-5, atol=1e-5)
    if columns > 2 and np.abs(weights.direct).max() > 0.1:
        assert not np.allclose(outputs(shape.spread(vector), n), plain(sensor, weights, n, signed=False), rtol=1e-3)
    assert weights.counts == (c1, c2)


@pytest.mark.parametrize(("rows", "columns"), [(2, 3), (4, 4), (5, 3)])
def test_the_gradient_is_that_of_the_loss(rows: int, columns: int) -> None:
    sensor, shape, vector = case(rows, columns, (3, 2), 1)
    rng = np.random.default_rng(2)
    n, forces = rng.normal(size=(7, sensor.taxels)), rng.normal(size=(7, 3))

    def loss(at: np.ndarray) -> tuple[np.ndarray, float]:
        found = plain(sensor, shape.weights(at), n)
        modulus = np.linalg.norm(forces, axis=1)
        each = np.sqrt(((found[:, :3] - forces) ** 2).sum(axis=1) / modulus**2 + SMOOTH**2)
        known = each if given is None else given
        return each, float(each.sum() + DOUBT * np.abs(found[:, 3] / modulus - known).sum())

    given: np.ndarray | None = None
    given, _ = loss(vector)
    total, dense = loss_and_gradient(Dense(*shape.spread(vector)), n, forces)
    assert total == pytest.approx(given.sum(), rel=1e-5)
    gradient, step = shape.gather(dense), 1e-5
    for place in range(shape.length):
        unit = np.zeros(shape.length)
        unit[place] = step
        slope = (loss(vector + unit)[1] - loss(vector - unit)[1]) / (2 * step)
        assert gradient[place] == pytest.approx(slope, rel=1e-3, abs=1e-4), place


def test_parameters_have_the_names_of_weights() -> None:
    _, shape, vector = case(3, 4, (2, 5), 3)
    assert tuple(shape.split(vector)) == NAMES
    assert np.array_equal(np.concatenate([part.ravel() for part in shape.split(vector).values()]), vector)


def test_augmentation_follows_its_seed_and_stays_small() -> None:
    frames = -np.random.default_rng(4).random((4000, 25)).astype(np.float32)
    before = frames.copy()
    found, again, other = (augmented(frames, np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert np.array_equal(frames, before)
    assert np.array_equal(found, again)
    assert not np.array_equal(found, other)
    dead = (found == 0).sum(axis=1)
    assert set(dead) == {0, 1}
    assert 0.07 < dead.mean() < 0.13
    assert 0.005 < np.median(np.abs(found - frames).max(axis=1)) < 0.05


def test_augmentation_has_no_scale() -> None:
    frames = -np.random.default_rng(7).random((50, 16)).astype(np.float32)
    found, halved = (augmented(scale * frames, np.random.default_rng(8)) for scale in (np.float32(1), np.float32(0.5)))
    assert np.array_equal(halved, 0.5 * found)
