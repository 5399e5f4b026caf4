"""The network in single precision, folded by the mirrors, and the gradient of its loss, by hand.

Parameters are :class:`tfra.model.learned.network.Folded`; the parity is the first axis of all vectors.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Bools, Singles
from tfra.model.choices import SERIAL, Choices
from tfra.model.fixed.butterfly import taxel_index
from tfra.model.learned.network import MIRRORS, OUTPUTS, READ, Folded, Weights, butterfly_first, layer, read
from tfra.model.sensor import SensorArray
from tfra.train.rounding import EXACT, Exact

SMOOTH, TANGENTIAL = 1e-3, 1.5
"""The loss of a frame is (|dF|^2 + SMOOTH^2 |F|^2)^(1/2) / |F|, where dF_x and dF_y count ``TANGENTIAL`` times."""

DOUBT = 1.0
"""Weight of the uncertainty's squared error, over |F|, beside the loss of the forces."""

UNEXPLAINED = 0.5
"""Least |dF|/|F| that the uncertainty is trained to for frames that no single contact explains."""

_STRETCH = np.array([TANGENTIAL, TANGENTIAL, 1], np.float32)

_READS = np.equal.outer(range(MIRRORS), READ).astype(np.float32)
"""1 where an output reads a parity, ``(parities, 1, outputs)``."""


@dataclass(frozen=True)
class Shape:
    """The network of an array and its counts C1, C2."""

    sensor: SensorArray
    counts: tuple[int, int]

    @cached_property
    def _places(self) -> np.typing.NDArray[np.int64]:
        """Taxels of every quad, ``(4, Q)``."""
        return taxel_index(Choices(self.sensor, architecture=SERIAL)).T  # which reads the array alone

    @property
    def sizes(self) -> list[tuple[int, ...]]:
        """Shapes of the parameters."""
        (c1, c2), quads, outputs = self.counts, self._places.shape[1], len(OUTPUTS)
        return [(MIRRORS, quads, c1), (MIRRORS, c1, c2), (outputs, c2), (outputs, c1), (outputs, quads)]

    @property
    def length(self) -> int:
        """Number of parameters."""
        return sum(int(np.prod(size)) for size in self.sizes)

    def split(self, vector: Singles) -> Folded[Singles]:
        """Views of a vector of parameters."""
        ends = np.cumsum([int(np.prod(size)) for size in self.sizes])
        parts = np.split(vector, ends[:-1])
        return Folded(*(part.reshape(size) for part, size in zip(parts, self.sizes, strict=True)))

    @property
    def scale(self) -> Singles:
        """Typical size of every parameter: He's for the layers, for frames over the sum of their magnitudes."""
        (c1, c2), taxels = self.counts, self.sensor.taxels
        sizes = 2.0, np.sqrt(2 / c1) / 4, 1 / np.sqrt(4 * c2), 1 / np.sqrt(4 * c1), 1 / np.sqrt(4 * taxels)
        return np.repeat(np.array(sizes, np.float32), [int(np.prod(size)) for size in self.sizes])

    def start(self, rng: np.random.Generator) -> Singles:
        """Random parameters of these sizes."""
        return self.scale * rng.standard_normal(self.length, np.float32)

    def folded(self, n: Singles) -> Singles:
        """Parities ``(4, k, Q)`` of frames ``n (k, m)``."""
        return butterfly_first(n[:, self._places].transpose(1, 0, 2))

    def weights(self, vector: Singles) -> Weights:
        """The parameters as ``Weights``: sums over parities are linear in the taxels, so unit frames give them."""
        part = self.split(vector)
        units = self.folded(np.eye(self.sensor.taxels, dtype=np.float32))
        direct = np.stack([units[parity] @ row for parity, row in zip(READ, part.direct, strict=True)]) / MIRRORS
        layers = (units @ part.first).sum(axis=0).T, butterfly_first(part.second).transpose(0, 2, 1)
        return Weights(*(each.astype(np.float64) for each in (*layers, part.read2, part.read1, direct)))


def estimates(parameters: Folded[Singles], inputs: Singles, rounding: Exact = EXACT) -> Singles:
    """Outputs ``(k, 4)`` for the parities ``inputs (4, k, Q)`` of frames, with parameters that are rounded."""
    return _passed(rounding.forward(parameters).parameters, inputs, rounding).outputs


class _Pass(NamedTuple):
    """Units of a forward pass, which of them are above zero at the mirrors, and its outputs."""

    h1: Singles
    above1: Bools
    h2: Singles
    above2: Bools
    outputs: Singles


def _passed(parameters: Folded[Singles], inputs: Singles, rounding: Exact) -> _Pass:
    h1, above1 = layer(inputs, parameters.first)
    h1 = rounding.operand("second", h1)
    h2, above2 = layer(h1, parameters.second)
    h2 = rounding.operand("read", h2)
    return _Pass(h1, above1, h2, above2, read(parameters, h2, h1, inputs))


def loss_and_gradient(
    vector: Folded[Singles], inputs: Singles, forces: Singles, weight: Singles, rounding: Exact = EXACT
) -> tuple[float, Folded[Singles]]:
    """The loss of a batch, and the gradient that a step follows.

    In: the parities ``inputs (4, k, Q)`` of k frames, their resultants ``forces (k, 3)`` over the same scale of each,
    and the ``weight (k, 1)`` of each frame.  Out: the sum of the weighted losses of the forces, and a gradient.

    The gradient is that of the sum plus ``DOUBT`` / 2 times (uncertainty - target)^2 / |F|^2 of every frame.  The
    target is |dF| of the present parameters, a constant for the gradient.  Where the weight is below one, it is
    ``UNEXPLAINED`` |F| at least.
    """
    parameters, scale = rounding.forward(vector)
    h1, above1, h2, above2, estimates = _passed(parameters, inputs, rounding)
    modulus = np.linalg.norm(forces, axis=1, keepdims=True)
    error = (estimates[:, :3] - forces) / modulus
    stretched = error * _STRETCH
    each = np.sqrt((stretched * stretched).sum(axis=1, keepdims=True) + np.float32(SMOOTH**2))
    target = np.maximum(np.linalg.norm(error, axis=1, keepdims=True), np.float32(UNEXPLAINED) * (weight < 1))
    doubt = np.float32(DOUBT) * (estimates[:, 3:] / modulus - target)
    back = np.concatenate([weight * stretched * _STRETCH / each, doubt], axis=1) / modulus
    to_h2, to_h1 = (back @ (_READS[:, :, None] * rows) for rows in (parameters.read2, parameters.read1))
    back2 = butterfly_first(butterfly_first(to_h2) * above2)
    back1 = butterfly_first(butterfly_first(to_h1 + back2 @ parameters.second.swapaxes(1, 2)) * above1)
    gradient = Folded(
        inputs.swapaxes(1, 2) @ back1,
        h1.swapaxes(1, 2) @ back2,
        *((back.T @ h)[READ, range(len(OUTPUTS))] for h in (h2, h1, inputs)),
    )
    return float((weight * each).sum()), Folded(*(part * each for part, each in zip(gradient, scale, strict=True)))
