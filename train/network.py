"""The network as an ordinary dense one in single precision, and the gradient of its loss, by hand.

Every matrix of :class:`tfra.model.learned.weights.Weights` is spread over the mirrors, which only copies and signs its
numbers.  So a gradient of the spread matrices is gathered by the transposed copies.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.learned.weights import MIRRORS, OUTPUTS, Weights
from tfra.model.sensor import SensorArray
from tfra.train.simulator import Singles

SMOOTH = 1e-3
"""The loss of a frame is (|dF|^2 + SMOOTH^2 |F|^2)^(1/2) / |F|."""

DOUBT = 0.1
"""Weight of the uncertainty's own error, over |F|, beside that of the forces."""

PRODUCT = np.bitwise_xor.outer(np.arange(MIRRORS), np.arange(MIRRORS))
"""Number of the product of two mirrors."""

CHARACTER = np.array([[1, -1, 1, -1], [1, 1, -1, -1], [1, 1, 1, 1], [1, 1, 1, 1]], np.float32)
"""Signs of F_x, F_y, F_z and the uncertainty under e, X, Y, XY."""


class Dense(NamedTuple):
    """Spread matrices; the network is F = ReLU(ReLU(n first') second') read2' + ReLU(n first') read1' + n direct'."""

    first: Singles  # (4 C1, m)
    second: Singles  # (4 C2, 4 C1)
    read2: Singles  # (4, 4 C2)
    read1: Singles  # (4, 4 C1)
    direct: Singles  # (4, m)


@dataclass(frozen=True)
class Shape:
    """The network of an array: its taxels under the four mirrors ``(4, m)``, and its counts C1, C2."""

    mirrored: Ints
    counts: tuple[int, int]

    @classmethod
    def of(cls, sensor: SensorArray, counts: tuple[int, int]) -> Shape:
        """The network of ``sensor``."""
        places = np.arange(sensor.taxels).reshape(sensor.rows, sensor.columns)
        ways = (places, places[:, ::-1], places[::-1], places[::-1, ::-1])
        return cls(np.stack([way.ravel() for way in ways]), counts)

    @property
    def sizes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the arrays of ``Weights`` by their names."""
        (c1, c2), taxels, outputs = self.counts, self.mirrored.shape[1], len(OUTPUTS)
        read = {"read2": (outputs, c2), "read1": (outputs, c1), "direct": (outputs, taxels)}
        return {"first": (c1, taxels), "second": (4, c2, c1), **read}

    @property
    def length(self) -> int:
        """Number of parameters."""
        return sum(int(np.prod(size)) for size in self.sizes.values())

    def split(self, vector: Singles) -> dict[str, Singles]:
        """Views of a vector of parameters by the names of ``Weights``."""
        ends = np.cumsum([int(np.prod(size)) for size in self.sizes.values()])
        parts = np.split(vector, ends[:-1])
        return {name: part.reshape(size) for (name, size), part in zip(self.sizes.items(), parts, strict=True)}

    def weights(self, vector: Singles) -> Weights:
        """The parameters as ``Weights``."""
        return Weights(**{name: part.astype(np.float64) for name, part in self.split(vector).items()})

    @property
    def scale(self) -> Singles:
        """Typical size of every parameter: He's for the layers, for frames over the sum of their magnitudes."""
        c1, c2 = self.counts
        taxels = self.mirrored.shape[1]
        sizes = 4.0, np.sqrt(2 / (4 * c1)), 1 / np.sqrt(4 * c2), 1 / np.sqrt(4 * c1), 1 / np.sqrt(taxels)
        return np.repeat(np.array(sizes, np.float32), [int(np.prod(size)) for size in self.sizes.values()])

    def start(self, rng: np.random.Generator) -> Singles:
        """Random parameters of these sizes."""
        return self.scale * rng.standard_normal(self.length, np.float32)

    def spread(self, vector: Singles) -> Dense:
        """Spread the parameters over the mirrors."""
        part = self.split(vector)
        c1, c2 = self.counts
        return Dense(
            np.concatenate([part["first"][:, way] for way in self.mirrored]),
            part["second"][PRODUCT].transpose(0, 2, 1, 3).reshape(4 * c2, 4 * c1),
            (CHARACTER[:, :, None] * part["read2"][:, None]).reshape(len(OUTPUTS), -1),
            (CHARACTER[:, :, None] * part["read1"][:, None]).reshape(len(OUTPUTS), -1),
            np.asarray(
                sum(CHARACTER[:, g, None] * part["direct"][:, way] for g, way in enumerate(self.mirrored)), np.float32
            ),
        )

    def gather(self, dense: Dense) -> Singles:
        """Return the transposed ``spread`` of a gradient: a vector of parameters."""
        c1, c2 = self.counts
        blocks = dense.second.reshape(4, c2, 4, c1)
        mirrors = range(MIRRORS)
        parts = (
            sum(dense.first[g * c1 : (g + 1) * c1][:, way] for g, way in enumerate(self.mirrored)),
            np.stack([sum(blocks[g, :, g ^ k] for g in mirrors) for k in mirrors]),
            (dense.read2.reshape(-1, 4, c2) * CHARACTER[:, :, None]).sum(axis=1),
            (dense.read1.reshape(-1, 4, c1) * CHARACTER[:, :, None]).sum(axis=1),
            sum(CHARACTER[:, g, None] * dense.direct[:, way] for g, way in enumerate(self.mirrored)),
        )
        return np.concatenate([np.asarray(part, np.float32).ravel() for part in parts])


def outputs(dense: Dense, n: Singles) -> Singles:
    """Outputs ``(k, 4)`` of the network for frames ``n (k, m)``."""
    h1 = np.maximum(n @ dense.first.T, 0)
    return np.asarray(np.maximum(h1 @ dense.second.T, 0) @ dense.read2.T + h1 @ dense.read1.T + n @ dense.direct.T)


def loss_and_gradient(dense: Dense, n: Singles, forces: Singles) -> tuple[float, Dense]:
    """Sum the smoothed |dF|/|F| over frames ``n (k, m)`` with resultants ``forces (k, 3)``; return it and its gradient.

    Both are to be divided by the same scale of each frame before.  The gradient is that of the sum and of
    ``DOUBT`` times | uncertainty - |dF| | / |F|, in which |dF| counts as given.
    """
    h1 = np.maximum(n @ dense.first.T, 0)
    h2 = np.maximum(h1 @ dense.second.T, 0)
    modulus = np.linalg.norm(forces, axis=1, keepdims=True)
    found = h2 @ dense.read2.T + h1 @ dense.read1.T + n @ dense.direct.T
    error = (found[:, :3] - forces) / modulus
    each = np.sqrt((error * error).sum(axis=1, keepdims=True) + np.float32(SMOOTH**2))
    doubt = np.float32(DOUBT) * np.sign(found[:, 3:] / modulus - each)
    back = np.concatenate([error / each, doubt], axis=1) / modulus
    back2 = (back @ dense.read2) * (h2 > 0)
    back1 = (back @ dense.read1 + back2 @ dense.second) * (h1 > 0)
    gradient = Dense(back1.T @ n, back2.T @ h1, back.T @ h2, back.T @ h1, back.T @ n)
    return float(each.sum()), gradient
