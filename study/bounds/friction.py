"""Bounds on quotients of forces."""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants
from tfra.study.bounds.rotation import Rotation


def ratio(over: Floats, off: Floats, normal: Floats, normal_off: Floats) -> Floats:
    """|x'/z' - x/z| <= (|dx| + |x'/z'| |dz|) / (|z'| - |dz|), infinite where z' may be off by more than half.

    ``over`` and ``normal`` are |x'| and |z'|, ``off`` and ``normal_off`` bounds of their errors.  The same holds with
    the exact |x| and |z| instead.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(2 * normal_off <= normal, (off + over / normal * normal_off) / (normal - normal_off), np.inf)


def gained(design: Design, words: Ints) -> tuple[Floats, Floats]:
    """Errors ``(n,)`` of K |F_xy|, from a run of the CORDIC, and of K |F_z|, from its constant, of ``words (n, 3)``.

    The product with the constant is truncated: one unit at most.
    """
    size, rotation = np.abs(words).astype(np.float64), Rotation.of(design)
    constant = gain_constants(design)[0] / 2.0 ** (rotation.bits - 2)
    flat = rotation.modulus(np.hypot(size[:, 0], size[:, 1]))
    return flat, size[:, 2] * abs(constant - rotation.gain) + (size[:, 2] > 0)


def friction(design: Design, words: Ints) -> Floats:
    """Of mu ``(n,)``, before it is rounded, given ``words (n, 3)`` of F: the gain cancels, the errors of both stay."""
    size, gain = np.abs(words).astype(np.float64), Rotation.of(design).gain
    flat, normal = gained(design, words)
    return ratio(gain * np.hypot(size[:, 0], size[:, 1]), flat, gain * size[:, 2], normal)
