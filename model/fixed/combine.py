"""Vector updates ``z + s * x``: residuals of candidates, weights of forces (Eqs. 7, 8, 10), and sheared fields."""

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.matvec import operand
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.widths import scalar_fraction


def combine(design: Design, z: Ints, scalar: Ints, x: Ints) -> Ints:
    """``z + scalar * x`` for vectors ``(n, Q, 4)`` and scalars ``(n,)``; x enters as a multiplier operand."""
    exact, shift = products(design, scalar, x)
    return z + round_shift(exact, shift[:, None])


def products(design: Design, scalar: Ints, x: Ints) -> tuple[Ints, Ints]:
    """Exact ``scalar * x (n, Q, 4)``, and the shift ``(n, 4)`` that brings it to the vector grid."""
    bits = design.formats.bits("operand.combine")
    words, significant = operand(x, bits)
    return scalar[:, None, None] * words, scalar_fraction(design) + bits - 1 - significant
