"""The folded network against the plain definition, and its gradient against differences of the loss."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.model.learned.plain import plain
from tfra.model.learned.network import outputs
from tfra.model.sensor import SensorArray
from tfra.train.augment import augmented, broken
from tfra.train.network import DOUBT, SMOOTH, TANGENTIAL, UNEXPLAINED, Shape, loss_and_gradient


def case(rows: int, columns: int, counts: tuple[int, int], seed: int) -> tuple[Shape, np.ndarray]:
    shape = Shape(SensorArray(rows, columns, 1.0, 1.0, 1.0), counts)
    return shape, np.random.default_rng(seed).normal(size=shape.length)  # doubles, for differences


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 6), st.integers(2, 6), st.integers(1, 4), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_the_parameters_are_those_of_the_plain_network(rows: int, columns: int, c1: int, c2: int, seed: int) -> None:
    shape, vector = case(rows, columns, (c1, c2), seed)
    n = np.random.default_rng(seed).normal(size=(5, rows * columns))
    weights, found = shape.weights(vector), outputs(shape.split(vector), shape.folded(n))
    largest = np.abs(found).max()
    np.testing.assert_allclose(found, plain(shape.sensor, weights, n), rtol=1e-5, atol=1e-5 * largest)
    if columns > 2 and np.abs(weights.direct).max() > 0.1:
        assert not np.allclose(found, plain(shape.sensor, weights, n, signed=False), rtol=1e-3)
    assert weights.counts == (c1, c2)


@pytest.mark.parametrize(("rows", "columns"), [(2, 3), (4, 4), (5, 3)])
def test_the_gradient_is_that_of_the_loss(rows: int, columns: int) -> None:
    shape, vector = case(rows, columns, (3, 2), 1)
    rng = np.random.default_rng(2)
    n, forces, weight = rng.normal(size=(7, rows * columns)), rng.normal(size=(7, 3)), rng.uniform(size=(7, 1))
    weight[3:] = 1

    def loss(at: np.ndarray) -> tuple[np.ndarray, float, float]:
        found = plain(shape.sensor, shape.weights(at), n)
        modulus = np.linalg.norm(forces, axis=1)
        error = found[:, :3] - forces
        stretched = ((error * [TANGENTIAL, TANGENTIAL, 1]) ** 2).sum(axis=1)
        weighted = float((weight[:, 0] * np.sqrt(stretched / modulus**2 + SMOOTH**2)).sum())
        off = np.linalg.norm(error, axis=1) / modulus
        told = np.maximum(off if given is None else given, UNEXPLAINED * (weight[:, 0] < 1))
        return off, weighted, weighted + DOUBT / 2 * float(((found[:, 3] / modulus - told) ** 2).sum())

    given: np.ndarray | None = None
    given, weighted, _ = loss(vector)
    taken = shape.folded(n)
    total, parts = loss_and_gradient(shape.split(vector), taken, forces, weight)
    assert total == pytest.approx(weighted, rel=1e-5)
    gradient, step = np.concatenate([part.ravel() for part in parts]), 1e-5
    assert shape.length == len(gradient)
    for place in range(shape.length):
        unit = np.zeros(shape.length)
        unit[place] = step
        slope = (loss(vector + unit)[2] - loss(vector - unit)[2]) / (2 * step)
        assert gradient[place] == pytest.approx(slope, rel=1e-3, abs=1e-4), place


def test_a_start_has_units_of_the_size_of_their_input() -> None:
    shape = Shape(SensorArray(6, 7, 1.0, 1.0, 1.0), (40, 30))
    n = np.random.default_rng(1).normal(size=(200, 42)).astype(np.float32)
    n /= np.abs(n).sum(axis=1, keepdims=True)
    vector = shape.start(np.random.default_rng(2))
    assert vector.dtype == np.float32
    found = outputs(shape.split(vector), shape.folded(n))
    assert found.dtype == np.float32
    assert 0.1 < np.std(found) < 10


def test_augmentation_follows_its_seed_and_stays_small_at_any_scale() -> None:
    frames = -np.random.default_rng(4).random((4000, 25)).astype(np.float32)
    before, peak = frames.copy(), np.abs(frames).max(axis=1, keepdims=True)
    found, again, other = (augmented(frames, peak, np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert np.array_equal(frames, before)
    assert np.array_equal(found, again)
    half = np.float32(0.5)
    assert np.array_equal(augmented(half * frames, half * peak, np.random.default_rng(5)), half * found)
    larger = augmented(frames, 10 * peak, np.random.default_rng(5))  # noise is that of the whole frame
    assert np.median(np.abs(larger - frames)) > 5 * np.median(np.abs(found - frames))
    assert not np.array_equal(found, other)
    dead = (found == 0).sum(axis=1)
    assert set(dead) == {0, 1}
    assert 0.03 < dead.mean() < 0.05
    assert 0.005 < np.median(np.abs(found - frames).max(axis=1)) < 0.05


def test_broken_taxels_are_dead_at_the_peak_or_stuck_below_it() -> None:
    frames = -np.random.default_rng(9).uniform(0.1, 1.0, (4000, 25)).astype(np.float32)
    found = frames.copy()
    which = broken(found, np.random.default_rng(10))
    assert 0.04 < len(which) / 4000 < 0.06
    changed = found != frames
    assert set(np.flatnonzero(changed.any(axis=1))) <= set(which)
    assert (changed.sum(axis=1) <= 1).all()
    assert (np.abs(found).max(axis=1) <= np.abs(frames).max(axis=1)).all()
    dead = which[(found[which] == 0).any(axis=1)]
    assert 0.4 < len(dead) / len(which) < 0.6
    assert (found[dead, frames[dead].argmin(axis=1)] == 0).all()
