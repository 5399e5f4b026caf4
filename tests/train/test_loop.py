"""Updates: orthogonal matrices against the singular value decomposition, Adam against its definition."""

import numpy as np
import pytest

from tfra.model.sensor import SensorArray
from tfra.train.loop import GAIN, LAYERS, MEAN, MOMENTUM, SQUARE, orthogonal, update
from tfra.train.network import Shape

SHAPE = Shape(SensorArray(4, 6, 1.0, 1.0, 1.0), (8, 5))


@pytest.mark.parametrize(("rows", "columns"), [(6, 6), (5, 9), (9, 5), (1, 4)])
def test_singular_values_come_close_to_one_and_directions_stay(rows: int, columns: int) -> None:
    rng = np.random.default_rng(1)
    matrices = rng.normal(size=(4, rows, columns)).astype(np.float32)
    u, _, v = np.linalg.svd(matrices, full_matrices=False)
    for scale in (1e-6, 1.0, 1e6):
        found = orthogonal(np.float32(scale) * matrices)
        assert found.shape == matrices.shape
        inner = np.swapaxes(u, 1, 2) @ found @ np.swapaxes(v, 1, 2)
        values = np.diagonal(inner, axis1=1, axis2=2)
        assert (np.abs(inner - values[:, None] * np.eye(inner.shape[1])) < 1e-3).all()
        assert values.min() > 0.3
        assert values.max() < 1.3
    assert not orthogonal(np.zeros_like(matrices)).any()


def test_layers_follow_the_momentum_and_the_rest_is_adam() -> None:
    rng = np.random.default_rng(2)
    gradients = rng.normal(size=(3, SHAPE.length)).astype(np.float32)
    mean, square = np.zeros((2, SHAPE.length), np.float32)
    found = [update(SHAPE, gradient, mean, square, step) for step, gradient in enumerate(gradients, 1)]
    momentum, first, second = (np.zeros(SHAPE.length) for _ in range(3))
    for step, gradient in enumerate(gradients.astype(np.float64), 1):
        momentum = MOMENTUM * momentum + (1 - MOMENTUM) * gradient
        first, second = MEAN * first + (1 - MEAN) * gradient, SQUARE * second + (1 - SQUARE) * gradient**2
        adam = first / (1 - MEAN**step) / (np.sqrt(second / (1 - SQUARE**step)) + 1e-8)
        ahead = (MOMENTUM * momentum + (1 - MOMENTUM) * gradient).astype(np.float32)
        parts = zip(SHAPE.split(found[step - 1]), SHAPE.split(ahead), SHAPE.split(adam.astype(np.float32)), strict=True)
        for number, (part, taken, other) in enumerate(parts):
            if number < LAYERS:
                expected = GAIN * np.sqrt(max(part.shape[1:])) * orthogonal(taken)
                np.testing.assert_allclose(part, expected, rtol=1e-3, atol=1e-4)
                assert 0.5 * GAIN < np.sqrt((part**2).mean()) < 1.2 * GAIN
            else:
                np.testing.assert_allclose(part, other, rtol=1e-4)
