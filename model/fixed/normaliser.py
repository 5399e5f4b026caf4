"""Block-floating input: a frame is shifted so that its largest code fills the word, and keeps its exponent."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.choices import Choices
from tfra.model.converter import saturated
from tfra.model.fixed.numbers import significant_bits


@dataclass(frozen=True)
class Normalised:
    """A normalised frame: ``stress (n, m)`` = codes << ``exponent (n,)``."""

    stress: Ints
    exponent: Ints
    magnitude: Ints
    """Sum of |b| (Eq. 29)."""
    contact: Bools
    """A code is negative, and one reaches the contact threshold."""
    traction: Bools
    saturated: Bools
    """A code sits at an end of its range."""

    @property
    def regular(self) -> Bools:
        """Frames with both compression and traction: the only ones that are swept."""
        return self.contact & self.traction


def normaliser(choices: Choices, codes: Ints) -> Normalised:
    """Normalise ``codes (n, m)``."""
    threshold = choices.adc.threshold
    exponent = choices.adc.bits - 1 - significant_bits(codes, axis=1)
    stress = codes << exponent[:, None]
    return Normalised(
        stress,
        exponent,
        np.abs(stress).sum(axis=1),
        np.asarray((codes < 0).any(axis=1) & ((codes < -threshold) | (codes >= threshold)).any(axis=1)),
        np.asarray((codes > 0).any(axis=1)),
        saturated(choices, codes),
    )
