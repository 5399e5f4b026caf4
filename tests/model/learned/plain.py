"""The network by its definition: every mirror's units, one after the other."""

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray

CHI = np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, 1, 1, 1], [1, 1, 1, 1]])


def mirrored(sensor: SensorArray, n: Floats, g: int) -> Floats:
    """g n of vectors ``(frames, m)``: 1 reverses columns, 2 rows, 3 both."""
    frames = n.reshape(-1, sensor.rows, sensor.columns)
    frames = frames[:, :, ::-1] if g & 1 else frames
    frames = frames[:, ::-1] if g & 2 else frames
    return frames.reshape(len(n), -1)


def plain(sensor: SensorArray, weights: Weights, n: Floats, signed: bool = True) -> Floats:
    """Outputs ``(frames, 4)``; not ``signed``: with chi = 1 everywhere."""
    images = [mirrored(sensor, n, g) for g in range(4)]
    h1 = [np.maximum(image @ weights.first.T, 0.0) for image in images]
    h2 = [np.maximum(sum(h1[k] @ weights.second[g ^ k].T for k in range(4)), 0.0) for g in range(4)]
    parts = [h2[g] @ weights.read2.T + h1[g] @ weights.read1.T + images[g] @ weights.direct.T for g in range(4)]
    return np.asarray(sum((CHI[:, g] if signed else 1) * parts[g] for g in range(4)))
