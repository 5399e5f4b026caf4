"""Word lengths and memories of the serial core, from the design's widths."""

from __future__ import annotations

from dataclasses import dataclass

from tfra.hdl.serial.isa import ADDRESS_BITS
from tfra.model.fixed.design import Design

STORE_BITS, STORE_DEPTH = 64, 1 << 14
"""The coefficient store: four SB_SPRAM256KA side by side."""


@dataclass(frozen=True)
class Sizes:
    """Of one design; bits are signed."""

    word: int
    """Data word: holds every exact integer of the model."""
    coefficient: int
    operand: int
    result: int
    """Forces and resultants."""
    lanes: int
    """Coefficients in a word of the store, and so sums at a time."""
    accumulator: int
    multiplicand: int
    multiplier: int
    reach: int
    """Longest shift to the left; a power of two, which is soon added."""
    shift: int
    """Bits of a shift's amount."""
    quotient: int
    """Bits of K."""


def sizes(design: Design) -> Sizes:
    """Sizes of ``design``."""
    w, fmt = design.widths, design.formats
    steps = design.search.steps
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
        multiplier=max(fmt.operand, w.magnitude, steps.bit_length()) + 1,
        reach=1 << max(w.division, fmt.operand + 2, design.adc.bits - 1 + fmt.vector_fraction).bit_length(),
        shift=8,
        quotient=max(fmt.operand + 3, ADDRESS_BITS),
    )


def sweep_bits(design: Design) -> int:
    """Bits of a number of candidates, 0 ... K + 1."""
    return design.candidates.bit_length()
