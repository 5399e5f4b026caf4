"""Matrix-vector products: block-normalised operands times folded coefficients, exact sums, one rounding."""

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import block_normalize, round_shift, significant_bits

EXACT_DOUBLE = 1 << 53
"""Sums of integers stay exact in float64 while every partial sum is below this."""


def operand(vector: Ints, bits: int) -> tuple[Ints, Ints]:
    """Words ``(n, Q, 4)`` of ``bits`` of a folded ``vector (n, Q, 4)``, and the bits each parity needed ``(n, 4)``."""
    significant = significant_bits(vector, axis=1)
    return block_normalize(vector, significant[:, None, :], bits), significant


def matvec(design: Design, stack: str, vector: Ints) -> Ints:
    """Result quads ``(n, quads, 4)`` of a stack's operators applied to ``vector (n, Q, 4)``, on the vector grid."""
    exact = exact_products(design, stack, vector)
    rounding = design.formats.rounding
    return np.concatenate([round_shift(sums, shift[:, None], rounding) for sums, shift in exact], axis=1)


def exact_products(design: Design, stack: str, vector: Ints) -> list[tuple[Ints, Ints]]:
    """What :func:`accumulate` gives for each operator of a stack, before anything of it is rounded."""
    bits = design.formats.bits(f"operand.{stack}")
    words, significant = operand(vector, bits)
    return [accumulate(op, words, bits, significant) for op in design.stacks[stack].operators]


def accumulate(op: Operator, words: Ints, bits: int, significant: Ints) -> tuple[Ints, Ints]:
    """Exact sums ``(n, quads, 4)`` of ``op``, and the shift ``(n, 4)`` that brings them to the vector grid.

    ``words (n, Q, 4)`` of ``bits``.  Row (i, parity) works on parity ``parity ^ flip``; sums are exact in float64 or in
    int64.
    """
    exact = float(np.abs(op.rows).sum(axis=-1).max()) * (1 << (bits - 1)) < EXACT_DOUBLE
    dtype = np.float64 if exact else np.int64
    sums = np.empty((len(words), op.quads, 4), dtype=np.int64)
    source = np.arange(4) ^ op.flip
    for parity in range(4):
        sums[:, :, parity] = words[:, :, source[parity]].astype(dtype) @ op.rows[:, parity].T.astype(dtype)
    return sums, op.fraction + bits - 1 - significant[:, source]
