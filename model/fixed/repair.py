"""Repairs: a taxel's code as a weighted sum of other codes.

A table is a list of words of 32 bits.  A header, bit 31 set, has the number of the taxel that is replaced in bits 30 to
18.  Each word after it has that of a source there, and its weight in bits 17 to 0, signed, in 1/65536.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.fixed.numbers import round_shift, saturate

HEADER = 1 << 31
PLACE = 18
"""The lowest bit of a taxel's number."""
ONE = 1 << 16
"""The weight 1."""

Real = TypeVar("Real", bound=np.floating[Any])


def repaired(codes: Ints, table: Ints, bits: int) -> tuple[Ints, Ints]:
    """Codes ``(n, m)`` of ``bits`` after the repairs in their order, and the largest magnitude written ``(n,)``.

    Sums stay below 2^46: 2^14 words, weights of 18 bits and codes of 16.  Words before the first header do nothing.
    """
    codes, largest = codes.copy(), np.zeros(len(codes), dtype=np.int64)
    for taxel, sources, weights in targets(table):
        code = saturate(round_shift(codes[:, sources] @ weights, 16), bits)
        codes[:, taxel] = code
        largest = np.maximum(largest, np.abs(code))
    return codes, largest


def filled(frames: npt.NDArray[Real], table: Ints) -> npt.NDArray[Real]:
    """``frames (n, m)`` of any unit with the taxels of ``table`` replaced, without the rounding of codes."""
    frames = frames.copy()
    for taxel, sources, weights in targets(table):
        frames[:, taxel] = frames[:, sources] @ (weights / ONE).astype(frames.dtype)
    return frames


def targets(table: Ints) -> Iterator[tuple[int, Ints, Ints]]:
    """Each taxel that is repaired in turn, its sources ``(k,)`` and their weights ``(k,)`` in 1/65536."""
    for start, stop in pairwise([*np.flatnonzero(table & HEADER), len(table)]):
        numbers = (table[start:stop] & ~HEADER) >> PLACE
        low = table[start + 1 : stop] & ((1 << PLACE) - 1)
        yield int(numbers[0]), numbers[1:], (low ^ (1 << (PLACE - 1))) - (1 << (PLACE - 1))
