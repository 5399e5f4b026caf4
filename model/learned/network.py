"""The network of the learned estimator, folded by the mirrors: a quarter of the products, the same numbers.

A sum over the group of mirrors becomes a product for each parity (EE, OX, OY, OO) after the butterfly of
:mod:`tfra.model.fixed.butterfly`.  So n is folded once, every matrix is transformed once, and each layer is

    four products, one a parity  ->  butterfly  ->  ReLU at each mirror  ->  butterfly.

F_x is odd in x, F_y odd in y, F_z and the uncertainty are even in both, so each output reads one parity alone.
"""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.choices import SERIAL, Choices
from tfra.model.fixed.butterfly import EE, OX, OY, butterfly, taxel_index, to_quads
from tfra.model.learned.weights import MIRRORS, Weights
from tfra.model.sensor import SensorArray

READ = (OX, OY, EE, EE)
"""Parity that each output reads."""


@dataclass(frozen=True, eq=False)
class Folded:
    """Weights in the basis of parities, for Q quads.

    ``first (4, Q, C1)`` and ``second (4, C1, C2)`` have the parity first and multiply from the right; a quarter in them
    undoes the factor of two butterflies.  ``read2 (4, C2)``, ``read1 (4, C1)``, ``direct (4, Q)``.
    """

    first: Floats
    second: Floats
    read2: Floats
    read1: Floats
    direct: Floats

    @classmethod
    def of(cls, choices: Choices, weights: Weights) -> "Folded":
        """Transform ``weights`` for the array of ``choices``."""
        places = taxel_index(choices)
        copies = np.bincount(places.ravel())[places]  # a taxel on a middle line has more than one place in its quad
        first, direct = (butterfly(to_quads(choices, taken) / copies) for taken in (weights.first, weights.direct))
        second = butterfly(np.moveaxis(weights.second, 0, -1))
        return cls(
            first=np.ascontiguousarray(first.transpose(2, 1, 0)) / MIRRORS,
            second=np.ascontiguousarray(second.transpose(2, 1, 0)) / MIRRORS,
            read2=weights.read2,
            read1=weights.read1,
            direct=np.stack([direct[output, :, parity] for output, parity in enumerate(READ)]),
        )


class Network:
    """The network of one sensor.

    Raises ``ValueError`` that starts with ``first:`` for ``weights`` of another number of taxels.
    """

    def __init__(self, sensor: SensorArray, weights: Weights) -> None:
        if weights.taxels != sensor.taxels:
            raise ValueError(f"first: {sensor.taxels} taxels are needed, got {weights.taxels}")
        self.sensor = sensor
        self._choices = Choices(sensor, architecture=SERIAL)  # the butterfly reads the array alone
        self._folded = Folded.of(self._choices, weights)

    @property
    def products(self) -> int:
        """Products of real numbers that a frame takes."""
        return sum(matrix.size for matrix in vars(self._folded).values())

    def __call__(self, n: Floats) -> Floats:
        """Outputs ``(frames, 4)`` in N for the normal forces ``n (frames, m)`` in N, compression negative."""
        taken = np.moveaxis(butterfly(to_quads(self._choices, n)), -1, 0)
        h1 = _layer(taken, self._folded.first)
        h2 = _layer(h1, self._folded.second)
        terms = (h2, self._folded.read2), (h1, self._folded.read1), (taken, self._folded.direct)
        return np.stack(
            [sum(h[parity] @ read[output] for h, read in terms) for output, parity in enumerate(READ)], axis=1
        )


def _layer(parities: Floats, matrices: Floats) -> Floats:
    """Parities ``(4, frames, C)`` of a layer, from those of its input ``(4, frames, K)``."""
    mirrors = butterfly(np.moveaxis(parities @ matrices, 0, -1))
    return np.moveaxis(butterfly(np.maximum(mirrors, 0.0)), -1, 0)
