"""The front end between the converters and the core: what it is built for."""

from __future__ import annotations

from tfra.model.fixed.design import Design

WORD = 16
"""Bits of a converter's word, of which the low ones are used."""
DEVIATION = 18
"""Bits of a mean less its offset, signed, in 1/2^17 of the converter's range; also those of an offset."""
GAIN = 17
"""Bits of a gain, unsigned."""
UNITY = 1 << 15
"""The gain 1."""
WEIGHT = 18
"""Bits of a weight of a repair, signed, in 1/65536."""
PRODUCT_POINT = 32
"""Of a product of deviation and gain, this less the bits of a code are below the code's point."""
MOST_AVERAGED = 6
"""Largest log2 of the frames of a mean."""


def repair_places(taxels: int) -> int:
    """Words of the table of repairs: enough for a tenth of the ``taxels``, each with twelve neighbours; a power of two.

    A block memory has 512 places at least.
    """
    return max(512, 1 << (13 * -(-taxels // 10) - 1).bit_length())


def check(design: Design) -> None:
    """Raise ``ValueError`` for a design that the front end can't be built for."""
    if not 8 <= design.adc.bits <= WORD:
        raise ValueError(f"adc.bits: 8 to {WORD} are supported with the front end, got {design.adc.bits}")
