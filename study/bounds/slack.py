"""What one rounding of the model may be off by, in units of the value that is rounded; arrays of float64."""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.coefficients import Operator
from tfra.model.fixed.matvec import operand
from tfra.model.fixed.numbers import bit_length, block_normalize, significant_bits
from tfra.model.rounding import Rounding


def shifted(shift: npt.ArrayLike, rounding: Rounding = Rounding.HALF_UP) -> Floats:
    """Of a right shift, in units of the result: 1/2, 1 of what truncates, nothing if nothing is shifted out."""
    return np.where(np.asarray(shift) > 0, 1.0 if rounding is Rounding.TRUNCATE else 0.5, 0.0)


def filled(value: Ints, axis: int | tuple[int, ...], bits: int, zeros: int = 0) -> Floats:
    """Of words of ``bits`` that ``value`` fills along ``axis``: |error| <= min(unit / 2, |value|), a unit at the limit.

    A word at the limit stands for less than 2^significant, which is one unit more than the limit.  The lowest ``zeros``
    bits of all values are zero; to lose these costs nothing.
    """
    significant = np.expand_dims(significant_bits(value, axis), axis)
    shift = significant - (bits - 1)
    limited = block_normalize(value, significant, bits) == (1 << (bits - 1)) - 1
    unit = np.where(shift > zeros, 2.0**shift, 0.0)
    return np.minimum(np.where(limited, unit, unit / 2), np.abs(value))


def cut(value: Ints, bits: int) -> Floats:
    """Of ``value``, of which the highest ``bits`` stay: less than a unit of these."""
    return 2.0 ** np.maximum(bit_length(value) - bits, 0) - 1


def row(op: Operator, exact: Floats, vector: Ints, bits: int, rounding: Rounding) -> Floats:
    """Of a product's rows ``(n, rows)``: |error| <= sum_j |C'_ij - C_ij| |x_j|, and the rounding of the result.

    ``exact (rows, 4 Q)`` is C, not quantised; the rounding of the operand ``vector (n, Q, 4)`` is not in it.
    """
    quantised = matrix(op.rows / 2.0**op.fraction, op.flip)
    _, significant = operand(vector, bits)
    shift = op.fraction + bits - 1 - significant[:, np.arange(4) ^ op.flip]
    carried = quantised.any(axis=1).reshape(op.quads, 4)  # a row of zeros is not rounded
    result = (shifted(shift, rounding)[:, None] * carried).reshape(len(vector), -1)
    flat = np.abs(vector.reshape(len(vector), -1))
    return np.asarray(flat @ np.abs(quantised - exact).T + result)


def matrix(rows: Floats, flip: int) -> Floats:
    """Rows ``(n, 4, K)`` of an operator as a matrix ``(4 n, 4 K)`` of folded vectors."""
    quads, parity, columns = len(rows), np.arange(4), rows.shape[-1]
    folded = np.zeros((quads, 4, columns, 4))
    folded[:, parity, :, parity ^ flip] = np.moveaxis(rows, 1, 0)
    return folded.reshape(4 * quads, 4 * columns)
