"""CORDIC in vectoring mode: the modulus (times the CORDIC gain) and the angle of a vector, by additions alone."""

import math

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import fit, round_shift
from tfra.model.rounding import Overflow, Rounding

ANGLE_GUARD = 4
"""Bits of the angle beyond those of a result word."""


def iterations(design: Design) -> int:
    """Rotations of a run: one for each bit of the angle."""
    return design.formats.bits("cordic")


def cordic_gain(design: Design) -> float:
    """Product of the rotations' lengthening, about 1.6468."""
    return math.prod(math.sqrt(1 + 4.0**-i) for i in range(iterations(design)))


def angle_table(design: Design) -> list[int]:
    """atan(2^-i) in units of ``2^-(iterations + ANGLE_GUARD)`` turns."""
    scale = 2.0 ** (iterations(design) + ANGLE_GUARD) / (2 * math.pi)
    return [round(math.atan(2.0**-i) * scale) for i in range(iterations(design))]


def cordic(design: Design, x: Ints, y: Ints) -> tuple[Ints, Ints]:
    """Modulus times :func:`cordic_gain`, and angle in ``2^-iterations`` turns, of vectors ``(n,)``.

    Vectors of the left half plane are turned by half a turn first.  Each rotation truncates.
    """
    turn = iterations(design) + ANGLE_GUARD
    left = x < 0
    x, y = np.where(left, -x, x), np.where(left, -y, y)
    angle = np.where(left, np.int64(1) << (turn - 1), 0)
    for i, step in enumerate(angle_table(design)):
        up = y < 0
        x_shifted, y_shifted = (round_shift(word, i, Rounding.TRUNCATE) for word in (x, y))
        x, y = x + np.where(up, -y_shifted, y_shifted), y + np.where(up, x_shifted, -x_shifted)
        angle = angle + np.where(up, -step, step)
    return x, fit(round_shift(angle, ANGLE_GUARD), iterations(design), Overflow.WRAP)
