"""Weights of no meaning."""

import numpy as np

from tfra.model.learned.network import Weights


def random_weights(rng: np.random.Generator, taxels: int, c1: int, c2: int) -> Weights:
    shapes = (c1, taxels), (4, c2, c1), (4, c2), (4, c1), (4, taxels)
    return Weights(*(rng.normal(size=shape) for shape in shapes))
