"""Weights of the learned estimator: a network that the array's two mirrors commute with, without biases.

The mirrors form the group e, X, Y, XY, in this order everywhere: X reverses columns, Y rows.  The product of two
elements is the exclusive or of their numbers, and each is its own inverse.  With n = b pitch_x pitch_y, the normal
force at every taxel in N (compression negative), flattened row by row,

    h1[g, c] = ReLU( first[c] . (g n) )
    h2[g, c] = ReLU( sum over g', c' of second[g g', c, c'] h1[g', c'] )
    F[o]     = sum over g of chi[o, g] ( read2[o] . h2[g] + read1[o] . h1[g] + direct[o] . (g n) )

are the outputs of :data:`OUTPUTS` in N.  chi is -1 for F_x under X and XY and for F_y under Y and XY, else 1.
"""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats

MIRRORS = 4
"""Elements of the group."""

OUTPUTS = ("F_x", "F_y", "F_z", "uncertainty")
"""The resultant, and how unsure of it the network is; where that is negative, it stands for zero.  No error bar."""

NAMES = ("first", "second", "read2", "read1", "direct")
"""Names of the arrays."""


@dataclass(frozen=True, eq=False)
class Weights:
    """One network of m taxels, C1 orbits of units in its first layer and C2 in its second; float64 arrays.

    ``first (C1, m)``, ``second (4, C2, C1)``, ``read2 (4, C2)``, ``read1 (4, C1)``, ``direct (4, m)``.  Raises
    ``ValueError`` that starts with the name of an array of another shape, or with a number that is not finite.
    """

    first: Floats
    second: Floats
    read2: Floats
    read1: Floats
    direct: Floats

    def __post_init__(self) -> None:
        for name in NAMES:
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        for name, axes in (("first", 2), ("second", 3)):
            shape = getattr(self, name).shape
            if len(shape) != axes or 0 in shape:
                raise ValueError(f"{name}: an array of {axes} axes is needed, none of them empty, got shape {shape}")
        c2, (c1, taxels) = self.second.shape[1], self.first.shape
        outputs = len(OUTPUTS)
        layers = {"second": (MIRRORS, c2, c1)}
        needed = layers | {"read2": (outputs, c2), "read1": (outputs, c1), "direct": (outputs, taxels)}
        for name, shape in needed.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name}: shape {shape} is needed, got {getattr(self, name).shape}")
        for name in NAMES:
            if not np.isfinite(getattr(self, name)).all():
                raise ValueError(f"{name}: a number is not finite")

    @property
    def counts(self) -> tuple[int, int]:
        """C1, C2."""
        return len(self.first), self.second.shape[1]

    @property
    def taxels(self) -> int:
        """m."""
        return int(self.first.shape[1])
