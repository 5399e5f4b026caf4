"""Exact integer primitives shared by every block; the hardware uses the same definitions.

Rounding is half up, and overflow is saturation wherever a format is not wide enough by proof, unless
:mod:`tfra.model.rounding` says otherwise.
"""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.rounding import Overflow, Rounding


def signed_bits(magnitude: float) -> int:
    """Bits of a two's complement word that holds every integer in [-magnitude, magnitude]."""
    return int(magnitude).bit_length() + 1


def round_shift(value: npt.ArrayLike, shift: npt.ArrayLike, rounding: Rounding = Rounding.HALF_UP) -> Ints:
    """``value / 2^shift`` rounded; negative shifts multiply.  The caller bounds the result below 2^62."""
    x, s = np.asarray(value, dtype=np.int64), np.asarray(shift, dtype=np.int64)
    right = np.clip(s, 0, 62)
    half = (np.int64(1) << right) >> 1  # none where nothing is shifted out
    match rounding:
        case Rounding.HALF_UP:
            rounded = (x + half) >> right
        case Rounding.HALF_EVEN:
            even = (x >> right) & 1 == 0
            rounded = (x + half - (even & (half > 0))) >> right
        case Rounding.TRUNCATE:
            rounded = x >> right
    return np.asarray(rounded << np.clip(-s, 0, 62))


def saturate(value: npt.ArrayLike, bits: int) -> Ints:
    """``value`` limited to a signed word of ``bits``."""
    return np.clip(np.asarray(value, dtype=np.int64), -(1 << (bits - 1)), (1 << (bits - 1)) - 1)


def fit(value: Ints, bits: int, overflow: Overflow) -> Ints:
    """``value`` as a word of ``bits``: signed if it saturates, unsigned if it wraps."""
    match overflow:
        case Overflow.SATURATE:
            return saturate(value, bits)
        case Overflow.WRAP:
            return value & ((1 << bits) - 1)
        case Overflow.NEVER:
            return value


def bit_length(value: npt.ArrayLike) -> Ints:
    """Position of the highest set bit of non-negative integers below 2^62, plus one (zero has length zero)."""
    x = np.array(value, dtype=np.int64)
    length = np.zeros(x.shape, dtype=np.int64)
    for step in (32, 16, 8, 4, 2, 1):
        big = x >= np.int64(1) << step
        length += np.where(big, step, 0)
        x = np.where(big, x >> step, x)
    return length + (x > 0)


def significant_bits(value: npt.ArrayLike, axis: int | tuple[int, ...]) -> Ints:
    """Bits beside the sign that the words along ``axis`` need together.

    It is the bit length of the OR of ``x ^ sign(x)``: as in the hardware, with no exception for powers of two or for
    zero.
    """
    x = np.asarray(value, dtype=np.int64)
    return bit_length(np.bitwise_or.reduce(x ^ (x >> 63), axis=axis))


def block_normalize(value: npt.ArrayLike, significant: npt.ArrayLike, bits: int) -> Ints:
    """Words scaled by ``2^(bits - 1 - significant)`` to fill ``bits``, rounded half up and saturated."""
    shift = np.asarray(significant, dtype=np.int64) - (bits - 1)
    return saturate(round_shift(value, shift), bits)


def normalize(value: Ints, length: Ints, bits: int) -> Ints:
    """``value`` moved so that its top bit is bit ``bits - 1``; bits below are cut off."""
    shift = bits - length
    return np.where(shift >= 0, value << np.maximum(shift, 0), value >> np.maximum(-shift, 0))


def divide(numerator: npt.ArrayLike, denominator: npt.ArrayLike, fraction: int) -> Ints:
    """``numerator / denominator`` with ``fraction`` bits, magnitudes rounded half up, sign last.

    Denominators must not be zero and ``|numerator| < 2^(61 - fraction)``.
    """
    n, d = np.asarray(numerator, dtype=np.int64), np.asarray(denominator, dtype=np.int64)
    quotient = round_shift((np.abs(n) << (fraction + 1)) // np.abs(d), 1)
    return np.asarray(np.where((n < 0) != (d < 0), -quotient, quotient), dtype=np.int64)
