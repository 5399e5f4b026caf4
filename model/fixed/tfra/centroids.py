"""Direction of the tangential force from the centroids of compression and traction (Eqs. 11, 19-22).

With u = columns - j and v = rows - i as coordinates (prefix sums give these moments without a multiplier) and
magnitudes of both zones, c - t is proportional to (U_t S_c - U_c S_t, V_t S_c - V_c S_t): no division.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import block_normalize, significant_bits


@dataclass(frozen=True)
class Direction:
    """``cos`` and ``sin (n,)`` times a common factor, and the variable that is swept (Fig. 3)."""

    cos: Ints
    sin: Ints
    sweep_y: Bools
    negative: Bools
    vanishing: Bools


def pitch_ratio(design: Design) -> tuple[int, int]:
    """Integers in the ratio pitch_x : pitch_y, within the resolution of the direction."""
    x, y = design.sensor.pitch_x, design.sensor.pitch_y
    ratio = Fraction(min(x, y) / max(x, y)).limit_denominator(1 << (design.formats.bits("direction") - 2))
    pair = ratio.denominator, ratio.numerator
    return pair if x >= y else pair[::-1]


def moments(design: Design, codes: Ints) -> tuple[Ints, Ints]:
    """Sums ``(n, 2)`` and first moments ``(n, 2, 2)`` of the compression, then of the traction, of ``codes (n, m)``.

    Moments are those about u, then about v.
    """
    i, j = np.divmod(np.arange(design.sensor.taxels), design.sensor.columns)
    weights = np.stack([design.sensor.columns - j, design.sensor.rows - i], axis=1)
    zones = np.stack([np.maximum(-codes, 0), np.maximum(codes, 0)], axis=1)
    return zones.sum(axis=2), zones @ weights


def offset(sums: Ints, first: Ints) -> Ints:
    """c - t ``(n, 2)``, cleared of its denominators, of what :func:`moments` returns; exact."""
    return np.asarray(first[:, 1] * sums[:, :1] - first[:, 0] * sums[:, 1:])


def centroids(design: Design, codes: Ints) -> Direction:
    """Direction of ``codes (n, m)``; frames without one get cos > 0 and sin = 0."""
    exact = offset(*moments(design, codes))
    bits = design.widths.division
    length = block_normalize(exact, significant_bits(exact, axis=1)[:, None], bits) * np.array(pitch_ratio(design))
    x, y = length.T
    sweep_y = np.abs(y) > np.abs(x)
    vanishing = (x == 0) & (y == 0)
    word = design.formats.bits("direction")
    words = block_normalize(length, significant_bits(length, axis=1)[:, None], word)
    cos = np.where(vanishing, (1 << (word - 1)) - 1, words[:, 0])
    return Direction(cos, words[:, 1], sweep_y, np.where(sweep_y, y, x) < 0, vanishing)
