"""Word lengths and memories of the serial core, from the design's widths."""

from __future__ import annotations

from dataclasses import dataclass

from tfra.hdl.serial.isa import ADDRESS_BITS
from tfra.model.fixed.design import Design

STORE_BITS, STORE_DEPTH = 64, 1 << 14
"""Bits and number of words of the coefficient store: four SB_SPRAM256KA side by side."""


@dataclass(frozen=True)
class Sizes:
    """Bits of signed words unless noted."""

    word: int
    """Data word: holds every exact integer of the model."""
    coefficient: int
    """Word of an operator in the store."""
    operand: int
    """Word of a vector in a product."""
    result: int
    """Forces and resultants."""
    lanes: int
    """Number of coefficients in a word of the store, and so of sums at a time."""
    accumulator: int
    """Sum of a lane."""
    multiplicand: int
    """Source of MUL."""
    multiplier: int
    """Y."""
    reach: int
    """Longest shift to the left, in bits; a power of two, so that adding it is cheap."""
    shift: int
    """SH."""
    quotient: int
    """K, unsigned."""


def sizes(design: Design) -> Sizes:
    """Sizes of ``design``; a word is as long as the longest value that a stage of a frame stores in one."""
    w, fmt = design.widths, design.formats
    word = max(
        w.direction,
        max(w.b_xy, w.b_z) + 2,
        w.candidate + 2,
        w.accumulator + 1,
        w.vector + 2,
        w.force + fmt.operand + 2,
        w.division + fmt.operand + 5,
        2 * fmt.operand + 3,
        w.magnitude + fmt.operand + 1,
    )
    return Sizes(
        word=word,
        coefficient=fmt.coefficient,
        operand=fmt.operand,
        result=w.output,
        lanes=STORE_BITS // fmt.coefficient,
        accumulator=w.accumulator,
        multiplicand=max(w.vector + 1, w.force, w.division, w.moment + 1, w.stress + fmt.vector_fraction),
        multiplier=max(fmt.operand, w.magnitude, design.search.steps.bit_length()) + 1,
        reach=1 << max(w.division, fmt.operand + 2, design.adc.bits - 1 + fmt.vector_fraction).bit_length(),
        shift=8,
        quotient=max(fmt.operand + 3, ADDRESS_BITS),
    )


def sweep_bits(design: Design) -> int:
    """Bits of a candidate's number, 0 ... K, or of their count, K + 1; unsigned."""
    return design.candidates.bit_length()
