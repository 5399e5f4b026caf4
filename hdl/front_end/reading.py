"""A converter's word as a number, with what is wrong with it."""

from amaranth import Cat, Const, Value

from tfra.model.fixed.front_end import LEAST_WORD, WORD


def reading(word: Value, word_bits: Value, is_unsigned: Value) -> tuple[Value, Value, Value]:
    """Signed value of ``word`` times 2^(16 - ``word_bits``), 17 bits; whether it is saturated, and out of range.

    Combinational.  A word is saturated at both ends of its range, and out of range if the bits above are no extension
    of it.
    """
    unused = (WORD - word_bits)[:4]
    at_least = [unused >= bits for bits in range(1, WORD - LEAST_WORD + 1)]  # so many bits are unused, or more
    moved = (word << unused)[:WORD]
    sign = moved[-1]
    # Both ends have all bits set but for the sign, which an unsigned word has the other way round.
    ones = moved[:-1] ^ (sign ^ is_unsigned).replicate(WORD - 1)
    saturated = (ones | Cat(at_least, Const(0, LEAST_WORD - 1))).all()
    extension = word ^ (word[-1] & ~is_unsigned).replicate(WORD)
    above = Cat(at_least[::-1])  # the bits above the highest one of an unsigned word
    from_sign = Cat(at_least[::-1], Const(1, 1))
    outside_unsigned = (extension[LEAST_WORD:] & above).any()
    outside_signed = (extension[LEAST_WORD - 1 :] & from_sign).any() & ~is_unsigned
    return Cat(moved, sign & ~is_unsigned).as_signed(), saturated, outside_unsigned | outside_signed
