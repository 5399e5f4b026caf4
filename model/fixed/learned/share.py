"""The resultant, shared among the taxels as their normal forces p: f = F p / sum of p."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.numbers import bit_length, divide, normalize, round_shift, saturate


@dataclass(frozen=True)
class Share:
    """``mantissa (n, 3)`` and ``shift (n,)``: a taxel's force is ``p * mantissa / 2^shift`` in a result word.

    Where ``even (n,)`` is set, p is too small to tell anything, and every taxel's p is :func:`even_word`.
    """

    mantissa: Ints
    shift: Ints
    even: Bools


def share(design: Design, total: Resultant, p: Ints) -> Share:
    """Quotients of the resultant and the sum of ``p (n, m)``."""
    scalar, bits = design.formats.bits("scalar"), design.widths.division
    whole = p.sum(axis=1)
    even = (whole == 0) | (_shift(design, total, bit_length(whole)) < 0)
    whole = np.where(even, design.sensor.taxels * even_word(design), whole)
    length = bit_length(whole)
    quotient = divide(np.abs(total.words), normalize(whole, length, bits)[:, None], scalar - 1)
    mantissa = np.minimum(quotient, (1 << (scalar - 1)) - 1)
    return Share(np.where(total.words < 0, -mantissa, mantissa), _shift(design, total, length), even)


def even_word(design: Design) -> int:
    """p of every taxel where all are alike: the smallest power of two whose sum is long enough for any resultant."""
    fmt, w, taxels = design.formats, design.widths, design.sensor.taxels
    needed = w.vector + 1 - fmt.bits("scalar") - fmt.vector_fraction + fmt.force_fraction
    return 1 << max(0, needed - taxels.bit_length())


def shared(design: Design, part: Share, p: Ints) -> tuple[Ints, Bools]:
    """Forces ``(n, 3, m)`` in result words, and where one was limited ``(n,)``."""
    spread = np.where(part.even[:, None], even_word(design), p)
    wide = round_shift(spread[:, None] * part.mantissa[:, :, None], part.shift[:, None, None])
    words = saturate(wide, design.widths.output)
    return words, (wide != words).any(axis=(1, 2))


def _shift(design: Design, total: Resultant, length: Ints) -> Ints:
    """Right shift of ``p * mantissa``, for a sum of p of ``length`` bits."""
    fmt = design.formats
    significant = design.widths.division - 1 - total.exponent
    return length - significant + fmt.bits("scalar") - 2 + fmt.vector_fraction - fmt.force_fraction
