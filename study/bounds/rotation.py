"""Bounds on the CORDIC."""

import math
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, cordic_gain, iterations
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Rotation:
    """What truncating rotations add to a vector: ``x`` in last bits; ``y`` in those over the lengthening so far."""

    gain: float
    x: float
    y: float
    last: float
    """The last angle, in radians."""
    bits: int
    table: float
    """Roundings of the table of angles, together, in last bits of the angle."""

    @classmethod
    def of(cls, design: Design) -> "Rotation":
        """|dx'| <= |dx| + 2^-i |dy| + 1 after rotation i, and the same of y; the first shifts nothing out."""
        x = y = most = 0.0
        bits, gain = iterations(design), math.sqrt(2)
        for i in range(1, bits):
            most = max(most, y / gain)
            x, y = x + 0.5**i * y + 1, y + 0.5**i * x + 1
            gain *= math.sqrt(1 + 4.0**-i)
        unit = 2.0 ** (bits + ANGLE_GUARD) / (2 * math.pi)
        off = (abs(math.atan(2.0**-i) * unit - word) for i, word in enumerate(angle_table(design)))
        return cls(cordic_gain(design), x, most, math.atan(2.0 ** (1 - bits)), bits, sum(off) / 2**ANGLE_GUARD)

    def left(self, length: Floats) -> Floats:
        """Bound ``(n,)`` of the angle in radians that is left of vectors of ``length``.

        A step away from zero needs |y| <= the error of y, so what is left is at most the last angle + asin(y / |v|).
        """
        return np.asarray(self.last + np.arcsin(np.minimum(1.0, self.y / np.maximum(length, 1e-300))))

    def modulus(self, length: Floats) -> Floats:
        """Bound ``(n,)`` of |x' - K |v||: x' is K |v| cos(what is left), and the error of x; zero stays zero."""
        short = self.gain * length * (1 - np.cos(np.minimum(self.left(length), np.pi)))
        return np.where(length > 0, short + self.x, 0.0)

    def angle(self, length: Floats, words: Floats, off: Floats) -> Floats:
        """Bound ``(n,)`` of the angle in last bits: |angle(v') - angle(v)| <= asin(|v' - v| / |v'|), and what is left.

        ``length`` enters the rotations; before they were shifted the vectors had ``words``, which were ``off``.  There
        is none where they may be off by more than half.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            before = np.where(2 * off <= words, np.arcsin(np.minimum(1.0, off / words)), np.inf)
        return np.asarray((before + self.left(length)) * 2.0**self.bits / (2 * np.pi) + self.table + 0.5)
