"""Vector updates ``z + s * x``: candidates' residuals and the weights of the forces (Eqs. 7, 8, 10)."""

from __future__ import annotations

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import operand
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.scalars import scalar_fraction


def combine(design: Design, z: Ints, scalar: Ints, x: Ints) -> Ints:
    """``z + scalar * x`` for vectors ``(n, Q, 4)`` and scalars ``(n,)``; x enters as a multiplier operand."""
    bits = design.formats.bits("operand.combine")
    words, significant = operand(x, bits)
    shift = scalar_fraction(design) + bits - 1 - significant
    return z + round_shift(scalar[:, None, None] * words, shift[:, None, :])
