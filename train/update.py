"""The update of a step: orthogonalised momentum for the layers (Muon, Jordan et al. 2024), Adam for the rest.

The momentum of a layer's matrix is replaced by the nearest matrix with equal singular values.  So directions in which
the loss is flat are learned as fast as steep ones: the same loss takes a third of Adam's steps.
"""

import math

import numpy as np

from tfra.model.arrays import Singles
from tfra.train.network import Shape

LAYERS = 2
"""The first arrays of ``Folded`` are matrices of layers."""

MOMENTUM = 0.95
"""Decay rate of the layers' momentum."""

GAIN = 0.3
"""Root mean square of an update of the layers, for a rate of 1: about that of Adam."""

MEAN, SQUARE = 0.9, 0.999
"""Decay rates of Adam's moments."""

_QUINTIC = 3.4445, -4.7750, 2.0315
"""Coefficients of a x + b x^3 + c x^5, which moves singular values in (0, 1] close to 1 in five turns."""


def update(shape: Shape, gradient: Singles, mean: Singles, square: Singles, step: int) -> Singles:
    """Update of all parameters for a learning rate of 1, over each parameter's typical size.

    In: the ``gradient``, its running ``mean`` and the running mean of its ``square``, all vectors of parameters, and
    the number of the ``step``, from 1.  Both means are brought up to date in place.
    """
    size = sum(part.size for part in shape.split(gradient)[:LAYERS])
    layers, rest = slice(size), slice(size, None)
    for part, decay in ((layers, MOMENTUM), (rest, MEAN)):
        mean[part] += np.float32(1 - decay) * (gradient[part] - mean[part])
    square[rest] += np.float32(1 - SQUARE) * (gradient[rest] ** 2 - square[rest])
    change = np.empty_like(gradient)
    nesterov = np.float32(MOMENTUM) * mean + np.float32(1 - MOMENTUM) * gradient
    for matrices, momentum in zip(shape.split(change)[:LAYERS], shape.split(nesterov), strict=False):
        matrices[:] = np.float32(GAIN * math.sqrt(max(matrices.shape[1:]))) * orthogonal(momentum)
    first, second = mean[rest] / (1 - MEAN**step), square[rest] / (1 - SQUARE**step)
    change[rest] = first / (np.sqrt(second) + np.float32(1e-8))
    return change


def orthogonal(matrices: Singles) -> Singles:
    """Matrices ``(4, a, b)`` with their singular values moved close to 1, by five turns of Newton and Schulz."""
    a, b, c = (np.float32(each) for each in _QUINTIC)
    wide = matrices if matrices.shape[1] <= matrices.shape[2] else matrices.swapaxes(1, 2)
    x = wide / (np.linalg.norm(wide, axis=(1, 2), keepdims=True) + np.float32(1e-12))
    for _ in range(5):
        gram = x @ x.swapaxes(1, 2)
        x = a * x + (b * gram + c * (gram @ gram)) @ x
    return np.asarray(x if wide is matrices else x.swapaxes(1, 2))
