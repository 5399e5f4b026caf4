"""Word lengths and memories of the serial core, from the design's widths."""

from dataclasses import dataclass

from tfra.hdl.serial.isa import ADDRESS_BITS
from tfra.model.fixed.design import Design

STORE_BITS, STORE_DEPTH = 64, 1 << 14
"""Bits and number of words of the coefficient store: four SB_SPRAM256KA side by side."""


@dataclass(frozen=True)
class Sizes:
    """Bits of signed words unless noted."""

    word: int  # data word: holds every exact integer of the model
    coefficient: int  # word of an operator in the store
    operand: int  # word of a vector in a product
    result: int  # forces and resultants
    lanes: int  # number of coefficients in a word of the store, and so of sums at a time
    accumulator: int  # sum of a lane
    multiplicand: int  # source of MUL
    multiplier: int  # Y
    reach: int  # longest shift to the left, in bits; a power of two, so that adding it is cheap
    shift: int  # SH
    quotient: int  # K, unsigned


def lane_count(design: Design) -> int:
    """Multiplier lanes: as many as a word of the store has coefficients for."""
    return STORE_BITS // design.formats.coefficient


def sizes(design: Design, *, word: int, multiplicand: int, multiplier: int) -> Sizes:
    """Sizes of ``design``.

    ``word``, ``multiplicand`` and ``multiplier`` are the least bits that the estimator's own stages need of a data
    word, of a source of MUL and of Y; what the shared stages need is added here.
    """
    w, fmt = design.widths, design.formats
    left = w.alignment, w.division, fmt.operand + 2, design.adc.bits - 1 + fmt.vector_fraction
    shared = w.accumulator + 1, w.vector + 2, w.division + fmt.operand + 5, 2 * fmt.operand + 3
    return Sizes(
        word=max(word, *shared),
        coefficient=fmt.coefficient,
        operand=fmt.operand,
        result=w.output,
        lanes=lane_count(design),
        accumulator=w.accumulator,
        multiplicand=max(multiplicand, w.division + 1),
        multiplier=max(multiplier, fmt.operand + 1),
        reach=1 << max(left).bit_length(),
        shift=8,
        quotient=max(fmt.operand + 3, ADDRESS_BITS),
    )
