"""Repairs: a taxel's code as a weighted sum of other codes, and the weights for a dead taxel.

A table is a list of words of 32 bits.  A header, bit 31 set, has the number of the taxel that is replaced in bits 30 to
18.  Each word after it has that of a source there, and its weight in bits 17 to 0, signed, in 1/65536.
"""

from itertools import pairwise

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.numbers import round_shift, saturate

HEADER = 1 << 31
PLACE = 18
"""The lowest bit of a taxel's number."""
ONE = 1 << 16
"""The weight 1."""


def repaired(codes: Ints, table: Ints, bits: int) -> tuple[Ints, Ints]:
    """Codes ``(n, m)`` of ``bits`` after the repairs in their order, and the largest magnitude written ``(n,)``.

    Sums stay below 2^46: 2^14 words, weights of 18 bits and codes of 16.  Words before the first header do nothing.
    """
    codes, largest = codes.copy(), np.zeros(len(codes), dtype=np.int64)
    starts = [*np.flatnonzero(table & HEADER), len(table)]
    for start, stop in pairwise(starts):
        numbers = (table[start:stop] & ~HEADER) >> PLACE
        low = table[start + 1 : stop] & ((1 << PLACE) - 1)
        weights = (low ^ (1 << (PLACE - 1))) - (1 << (PLACE - 1))
        code = saturate(round_shift(codes[:, numbers[1:]] @ weights, 16), bits)
        codes[:, numbers[0]] = code
        largest = np.maximum(largest, np.abs(code))
    return codes, largest


def repairs(dead: Bools) -> Ints:
    """Words of the table for ``dead (rows, columns)``: the surface of least curvature through the other taxels.

    It is the thin plate: the sum of the squares of all second differences, mixed ones twice, is least.  In the middle
    of the array, a dead taxel alone is (8 near - 2 diagonal - far) / 20; edges and dead neighbours follow from the
    same sum.
    """
    return table(dead, thin_plate(dead))


def table(dead: Bools, weights: Floats) -> Ints:
    """Words of the table for ``weights (dead taxels, taxels)``; those that round to zero are left out."""
    words = []
    for taxel, row in zip(np.flatnonzero(dead), np.rint(weights * ONE), strict=True):
        limited = np.clip(row, -2 * ONE, 2 * ONE - 1).astype(np.int64)
        sources = np.flatnonzero(limited)
        words += [[HEADER | taxel << PLACE], sources << PLACE | limited[sources] & ((1 << PLACE) - 1)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *words]).astype(np.int64)


def thin_plate(dead: Bools) -> Floats:
    """Weights ``(dead taxels, taxels)`` of the surface of least curvature; zero for dead taxels."""
    size = dead.shape
    number = np.arange(dead.size).reshape(size)
    along, down = np.array([[1.0, -2.0, 1.0]]), np.array([[1.0], [-2.0], [1.0]])
    mixed = np.sqrt(2.0) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    energy = np.zeros((dead.size, dead.size))
    for stencil in (along, down, mixed):
        rows, columns = stencil.shape
        if rows > size[0] or columns > size[1]:
            continue
        places = np.lib.stride_tricks.sliding_window_view(number, stencil.shape).reshape(-1, stencil.size).T
        products = np.outer(stencil, stencil)[:, :, None]
        np.add.at(energy, (places[:, None], places[None]), products)
    flat = dead.ravel()
    weights = np.zeros((int(flat.sum()), dead.size))
    if flat.any() and not flat.all():
        inner, outer = energy[np.ix_(flat, flat)], energy[np.ix_(flat, ~flat)]
        weights[:, ~flat] = -np.linalg.lstsq(inner, outer, rcond=None)[0]
    return weights
