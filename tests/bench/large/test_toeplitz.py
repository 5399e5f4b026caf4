"""Convolutions and conjugate gradients against the dense operators."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from bench.large.toeplitz import Convolution, IterativeProducts, conjugate_gradients, kernels
from tfra.model.boussinesq import boussinesq, operators
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Dense, Tfra

SMALL = SENSORS["5×7, 3×3 mm, h 2 mm"]
EVEN = SENSORS["4×6, 5×3 mm, h 2 mm"]


def stress_of(sensor: SensorArray, count: int = 30) -> np.ndarray:
    return frames(sensor, random_contacts(sensor, count, np.random.default_rng(5)))


@settings(max_examples=30)
@given(rows=st.integers(2, 9), columns=st.integers(2, 9), pitch=st.floats(0.5e-3, 8e-3), seed=st.integers(0, 99))
def test_convolutions_are_the_dense_operators(rows, columns, pitch, seed):
    sensor = SensorArray(rows, columns, pitch, 2e-3, 3e-3)
    x = np.random.default_rng(seed).normal(size=(3, rows, columns))
    for kernel, matrix in zip(kernels(sensor), boussinesq(sensor), strict=True):
        dense = matrix * sensor.thickness**2
        expected = x.reshape(3, -1) @ dense.T
        assert_allclose(Convolution(kernel)(x).reshape(3, -1), expected, atol=1e-12)
        back = Convolution(kernel[::-1, ::-1])(x).reshape(3, -1)
        assert_allclose(back, x.reshape(3, -1) @ dense, atol=1e-12)


def test_a_wrong_kernel_is_noticed():
    x = np.random.default_rng(1).normal(size=(2, 5, 7))
    kernel = kernels(SMALL)[0].copy()
    expected = x.reshape(2, -1) @ boussinesq(SMALL)[0].T * SMALL.thickness**2
    kernel[3, 9] *= 1.001
    with pytest.raises(AssertionError):
        assert_allclose(Convolution(kernel)(x).reshape(2, -1), expected, atol=1e-12)


@settings(max_examples=30)
@given(size=st.integers(1, 12), count=st.integers(1, 4), seed=st.integers(0, 99))
def test_conjugate_gradients_end_after_as_many_steps_as_unknowns(size, count, seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(size, size))
    matrix, b = half @ half.T + size * np.eye(size), rng.normal(size=(count, size))
    found = conjugate_gradients(lambda x: x @ matrix, b, size)
    assert_allclose(found, np.linalg.solve(matrix, b.T).T, rtol=1e-6, atol=1e-9)


def test_conjugate_gradients_of_nothing_is_nothing_and_frames_do_not_mix():
    matrix = np.diag([1.0, 2.0, 5.0])
    b = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    assert_allclose(conjugate_gradients(lambda x: x @ matrix, b, 9), [[0, 0, 0], [1, 1, 0.6]], atol=1e-12)


@pytest.mark.parametrize("sensor", [SMALL, EVEN])
def test_converged_products_are_the_dense_ones(sensor):
    x = stress_of(sensor).reshape(30, -1)
    ops = operators(sensor)
    dense, found = Dense(ops), IterativeProducts(sensor)
    for got, expected in (
        (found.solve(x), dense.solve(x)),
        (found.normal(x), dense.normal(x)),
        *zip(found.stress(x), dense.stress(x), strict=True),
        *zip(found.forces(x), dense.forces(x), strict=True),
        *zip(found.sums, dense.sums, strict=True),
    ):
        assert_allclose(got, expected, atol=1e-9 * np.abs(expected).max())


def test_tfra_is_the_same_by_iteration_and_worse_with_few_steps_or_short_kernels():
    stress = stress_of(SMALL)
    exact = Tfra(SMALL)(stress)
    same = Tfra(SMALL, ops=IterativeProducts(SMALL))(stress)
    np.testing.assert_array_equal(same.sweep_index, exact.sweep_index)
    assert_allclose(same.forces, exact.forces, atol=1e-8)

    def error(**limits: int) -> float:
        found = Tfra(SMALL, ops=IterativeProducts(SMALL, **limits))(stress)
        return float(np.median(np.abs(found.forces - exact.forces)))

    assert error(steps=2) > 100 * error(steps=8) > 0
    assert error(radius=2) > error(radius=4) > 0
    assert error(radius=6) < 1e-8  # the whole array


def test_taps_are_counted():
    assert IterativeProducts(SMALL).taps == 9 * 13
    assert IterativeProducts(SMALL, radius=2).taps == 25
