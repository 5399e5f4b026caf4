"""Integer bits by proof: the largest magnitude of every quantity, from the coefficients, for any input.

All vectors live on one grid: one LSB is ``2^-vector_fraction`` of a converter code of the normalised frame.  Since
no vector can leave its word, nothing but the result words and one scalar ever saturates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tfra.model.design import Design
from tfra.model.fixed.coefficients import Operator, stacks, taxel_matrix
from tfra.model.fixed.numbers import signed_bits

MU_LIMIT = 4
"""Scalars (alpha, beta, mu_x, mu_y) lie in [-4, 4)."""

DIVISION_GUARD = 4
"""Bits that quotients' operands keep beyond a multiplier operand."""


@dataclass(frozen=True, slots=True)
class Widths:
    """Word lengths in bits, all signed unless said otherwise."""

    stress: int
    """Normalised taxel stress: as wide as a converter code."""
    vector: int
    """Any folded vector, and any result of a product."""
    accumulator: int
    """Exact sum of one row's products."""
    alignment: int
    """Zeros appended to an accumulator so that its dynamic shift to the vector grid only goes right."""
    moment: int
    """Unsigned first moment of the compressed (or stretched) taxels, in codes times taxels."""
    direction: int
    """Exact c - t cleared of its denominators."""
    candidate: int
    """K * (p + mu q) of one taxel, times four."""
    b_z: int
    """Unsigned sum of a candidate's positive parts."""
    b_xy: int
    """Unsigned |sum - sum| of Eq. 25."""
    force: int
    """Unscaled force of one taxel on the vector grid times four, less ``force_drop`` bits."""
    magnitude: int
    """Unsigned sum of |b| over the normalised frame, in codes."""
    division: int
    """Numerators and denominators of quotients; words of the CORDIC at its entry."""
    output: int
    """Scaled force or resultant in a result word."""


@lru_cache(maxsize=16)
def widths(design: Design) -> Widths:
    """Word lengths of ``design``.

    Raises ``ValueError`` naming ``formats``, or ``sensor``, when exact integers would not fit the 63 bits that the
    model can hold, that is when the formats could overflow.
    """
    fmt, m, k, code = design.formats, design.sensor.taxels, design.search.steps, 2 ** (design.adc.bits - 1)
    slack = 2.0 ** (2 - fmt.operand)
    op = {o.name: o for s in stacks(design).values() for o in s.operators}

    def product(operator: Operator, taxel: float) -> float:
        """Bound of a product's results in the taxel domain, operand rounding and result rounding included."""
        return (operator.gain + 4 * slack * operator.folded_gain) * taxel + 2

    def chain(first: Operator, second: Operator, taxel: float) -> float:
        """The same of two products in a row: what the second makes of the exact first, and of its rounding."""
        together = float(np.abs(taxel_matrix(design, second) @ taxel_matrix(design, first)).sum(axis=1).max())
        rounding = 4 * slack * first.folded_gain * taxel + 2
        return (
            together * taxel + second.gain * rounding + 4 * slack * second.folded_gain * product(first, taxel) + 2
        )

    b = float(code << fmt.vector_fraction)
    n = product(op["c33_inv"], b) + 1
    g, d1, d2 = (product(op[name], n) for name in ("c33", "c31", "c32"))
    d0, tangential = b + g, max(d1, d2)
    e0, e1 = d0 + 2 * tangential + 1, 3 * tangential + 1
    d = e0 + e1 + 1
    p, q = product(op["normal"], e0) + g, product(op["normal"], e1)
    y, force = d, max(product(o, d) for o in stacks(design)["force"].operators)
    if design.operators == "gram":
        y, force = product(op["gram"], d), max(chain(op["gram"], o, d) for o in stacks(design)["force"].operators)
    unscaled = force + MU_LIMIT * n + 2
    sums = product(op["sums_b"], b) + product(op["sums_n"], n)
    vector = signed_bits(max(4 * max(b, n, d0, d1, d2, e0, e1, d, p, q, y, unscaled), sums) + 4)
    row_sum = max(float(abs(o.rows).sum(axis=-1).max()) for o in op.values())
    candidate = 4 * k * (p + q)
    longest = max(design.sensor.rows, design.sensor.columns)
    result = Widths(
        stress=design.adc.bits,
        vector=vector,
        accumulator=signed_bits(row_sum * 2 ** (fmt.operand - 1)),
        alignment=max(0, *(vector - fmt.operand - o.fraction for o in op.values())),
        moment=(m * longest * code).bit_length(),
        direction=signed_bits(2 * m * longest * code * m * code),
        candidate=signed_bits(candidate),
        b_z=int(m * candidate).bit_length(),
        b_xy=int(m * (candidate + 4 * k * b)).bit_length(),
        force=vector - force_drop(design),
        magnitude=(m * code).bit_length(),
        division=fmt.operand + DIVISION_GUARD,
        output=design.adc.bits + (m - 1).bit_length() + fmt.force_fraction,
    )
    longest_word = {
        "direction": result.direction,
        "b_xy": result.b_xy + 1,
        "accumulator": result.accumulator + result.alignment + 1,
        "force": result.force + fmt.operand + 1,
    }
    for name, bits in longest_word.items():
        if bits > 63:
            key = "sensor" if name == "direction" else "formats"
            raise ValueError(f"{key}: {name} can overflow: {bits} bits are needed, 63 are supported")
    return result


def force_drop(design: Design) -> int:
    """Bits below the vector grid times four that unscaled forces do not keep: two beyond the result's own."""
    return max(0, design.formats.vector_fraction - design.formats.force_fraction)
