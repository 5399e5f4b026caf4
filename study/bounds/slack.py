"""What one rounding of the model may be off by, in units of the value that is rounded; arrays of float64."""

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.matvec import operand
from tfra.model.fixed.numbers import block_normalize, significant_bits
from tfra.model.rounding import Rounding


def shifted(shift: Ints, rounding: Rounding = Rounding.HALF_UP) -> Floats:
    """In units of the result: nothing without a right shift, else 1/2, or 1 of what truncates."""
    return np.where(shift > 0, 1.0 if rounding is Rounding.TRUNCATE else 0.5, 0.0)


def filled(value: Ints, axis: int | tuple[int, ...], bits: int) -> Floats:
    """Of words of ``bits`` that ``value`` fills along ``axis``: |error| <= min(unit / 2, |value|), a unit at the limit.

    A word at the limit stands for less than 2^significant, which is one unit more than the limit.
    """
    significant = significant_bits(value, axis)
    shift = np.expand_dims(significant, axis) - (bits - 1)
    words = block_normalize(value, np.expand_dims(significant, axis), bits)
    unit = np.where(shift > 0, 2.0**shift, 0.0)
    limited = words == (1 << (bits - 1)) - 1
    return np.minimum(np.where(limited, unit, unit / 2), np.abs(value))


def row(op: Operator, exact: Floats, vector: Ints, bits: int, rounding: Rounding) -> Floats:
    """Of a product's rows ``(n, rows)``: |error| <= sum_j |C'_ij - C_ij| |x_j|, and the rounding of the result.

    ``exact (rows, 4 Q)`` is C, not quantised; the rounding of the operand ``vector (n, Q, 4)`` is not in it.
    """
    quantised = matrix(op)
    _, significant = operand(vector, bits)
    shift = op.fraction + bits - 1 - significant[:, np.arange(4) ^ op.flip]
    carried = quantised.any(axis=1).reshape(op.quads, 4)  # a row of zeros is not rounded
    result = (shifted(shift, rounding)[:, None] * carried).reshape(len(vector), -1)
    flat = np.abs(vector.reshape(len(vector), -1))
    return np.asarray(flat @ np.abs(quantised - exact).T + result)


def matrix(op: Operator) -> Floats:
    """The quantised ``op`` as a matrix ``(rows, 4 Q)`` of folded vectors."""
    parity, columns = np.arange(4), op.rows.shape[-1]
    folded = np.zeros((op.quads, 4, columns, 4))
    folded[:, parity, :, parity ^ op.flip] = np.moveaxis(op.rows, 1, 0) / 2.0**op.fraction
    return folded.reshape(4 * op.quads, 4 * columns)
