"""Words of signals inside a bit-accurate model: their formats, and what rounding and limits did to them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.fixed.numbers import round_shift, saturate, significant_bits


@dataclass(frozen=True)
class Word:
    """A signal's word: the field of ``Widths``, or the format, that its length comes from.

    ``bound`` is the largest magnitude by proof; where ``proven`` is false, words are shifted to fill the format, or
    limited to it, and the bound is the format's.
    """

    stage: str
    name: str
    bits: int
    signed: bool
    bound: float
    proven: bool = True

    @classmethod
    def full(cls, stage: str, name: str, bits: int, signed: bool = True) -> "Word":
        """A word that may have all values of its ``bits``."""
        return cls(stage, name, bits, signed, float(2 ** (bits - 1) if signed else 2**bits - 1), proven=False)


@dataclass(frozen=True)
class Observed:
    """Values ``(n, …)`` of a signal; how many of them were ``rounded`` to another value, and how many ``saturated``.

    ``rounded`` is ``None`` after a CORDIC, which rounds in every rotation.
    """

    values: Ints
    rounded: int | None = 0
    saturated: int = 0


def cast(exact: Ints, shift: npt.ArrayLike, bits: int | None = None) -> Observed:
    """``exact / 2^shift`` as words, limited to ``bits`` if given."""
    shift = np.asarray(shift, dtype=np.int64)
    lost = exact & ((np.int64(1) << np.clip(shift, 0, 62)) - 1)
    wide = round_shift(exact, shift)
    values = wide if bits is None else saturate(wide, bits)
    return Observed(values, int(np.count_nonzero(lost)), int(np.count_nonzero(values != wide)))


def filled(exact: Ints, axis: int | tuple[int, ...], bits: int) -> Observed:
    """``exact`` words, those along ``axis`` shifted together to fill ``bits``."""
    significant = significant_bits(exact, axis)
    return cast(exact, np.expand_dims(significant, axis) - (bits - 1), bits)
