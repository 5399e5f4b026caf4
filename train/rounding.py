"""Training for the word lengths of a core: the forward pass rounds as the core does, the gradient passes straight.

The gradient is that of the rounded network, as if rounding changed nothing (Bengio et al. 2013).
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Singles
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.operators import PLACES, rounded
from tfra.model.learned.network import NAMES, Folded, fold

SIGNALS = (*(f"coefficient.{name}" for name in NAMES), *(f"operand.{name}" for name in ("first", "second", "read")))
"""Signals of the network."""


class Forward(NamedTuple):
    """Parameters of a forward pass, and what the gradient of each is worth for the parameter that it is made of."""

    parameters: Folded[Singles]
    scale: Folded[Singles]


class Exact:
    """No rounding, of weights that begin at random."""

    pace = 1.0
    """Learning rate, over that of weights that begin at random."""
    steps = 120_000
    """Steps without a budget."""

    @property
    def facts(self) -> Mapping[str, int | str]:
        """What the file of weights says of it."""
        return {}

    @property
    def counts(self) -> tuple[int, int] | None:
        """C1, C2 of the weights to begin with, if there are."""
        return None

    @property
    def start(self) -> Singles | None:
        """The parameters to begin with, if there are."""
        return None

    def forward(self, parameters: Folded[Singles]) -> Forward:
        """What a forward pass computes with."""
        one = np.ones(1, np.float32)
        return Forward(parameters, Folded(one, one, one, one, one))

    def operand(self, stack: str, parities: Singles) -> Singles:
        """Words ``(4, k, K)`` of the operand of a product."""
        return parities


EXACT = Exact()


@dataclass(frozen=True)
class Rounding(Exact):
    """The word lengths of ``design``, whose weights are those to begin with."""

    design: LearnedDesign
    pace = 0.5
    steps = 40_000

    @property
    def facts(self) -> Mapping[str, int | str]:
        """Word lengths, and a hash of the weights to begin with."""
        weights = hashlib.sha256(b"".join(getattr(self.design.weights, name).tobytes() for name in NAMES))
        return {name: self.design.formats.bits(name) for name in SIGNALS} | {"weights": weights.hexdigest()}

    @property
    def counts(self) -> tuple[int, int]:
        return self.design.weights.counts

    @property
    def start(self) -> Singles:
        return np.concatenate([part.ravel() for part in fold(self.design, self.design.weights)]).astype(np.float32)

    def forward(self, parameters: Folded[Singles]) -> Forward:
        """Coefficients of the core, whose units are smaller than those of the parameters."""
        rows, size1, size2 = rounded(self.design, Folded(*(part.astype(np.float64) for part in parameters)))
        reads = (np.stack([read[place] for place in PLACES]) for read in rows[2:])
        layers = (np.moveaxis(each, 0, -1) for each in rows[:2])
        scale = 1 / size1, size1[:, None] / size2, size2, size1, np.ones(1)
        return Forward(
            Folded(*(np.ascontiguousarray(each, np.float32) for each in (*layers, *reads))),
            Folded(*(each.astype(np.float32) for each in scale)),
        )

    def operand(self, stack: str, parities: Singles) -> Singles:
        """Words of a parity share the exponent of their largest, and round half up."""
        most = 1 << (self.design.formats.bits(f"operand.{stack}") - 1)
        _, exponent = np.frexp(np.abs(parities).max(axis=2, keepdims=True))
        step = np.ldexp(np.float32(1 / most), exponent)
        return np.asarray(np.clip(np.floor(parities / step + np.float32(0.5)), -most, most - 1) * step)
