"""A converter's word as a number, with what is wrong with it."""

from __future__ import annotations

from amaranth import Cat, Const, Value

from tfra.model.fixed.front_end import WORD

_FEWEST = 8
"""Bits of the shortest words."""


def reading(word: Value, word_bits: Value, is_unsigned: Value) -> tuple[Value, Value, Value]:
    """Signed value of ``word`` times 2^(16 - ``word_bits``), 17 bits; whether it is saturated, and out of range.

    Combinational.  A word is saturated at both ends of its range, and out of range if the bits above are no extension
    of it.
    """
    unused = (WORD - word_bits)[:4]
    more = [unused >= bits for bits in range(1, WORD - _FEWEST + 1)]  # so many bits are unused, or more
    moved = (word << unused)[:WORD]
    top = moved[-1]
    # Both ends have all bits set but for the sign, which an unsigned word has the other way round.
    ones = moved[:-1] ^ (top ^ is_unsigned).replicate(WORD - 1)
    saturated = (ones | Cat(more, Const(0, _FEWEST - 1))).all()
    extension = word ^ (word[-1] & ~is_unsigned).replicate(WORD)
    # From the sign on, or above the highest bit of an unsigned word.
    above, from_sign = Cat(more[::-1]), Cat(more[::-1], Const(1, 1))
    outside = (extension[_FEWEST:] & above).any() | ((extension[_FEWEST - 1 :] & from_sign).any() & ~is_unsigned)
    return Cat(moved, top & ~is_unsigned).as_signed(), saturated, outside
