"""The exact integer sweep: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

On the grid mu = kappa / K the numerator K p + kappa q is an integer, so candidates differ by additions of q and
nothing is rounded.  All values carry the factor 4 K of unfolded vectors times the grid.
"""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design


@dataclass(frozen=True)
class Sweep:
    """``index (n,)`` of the winner; ``b_z, b_xy (n, K + 1)`` in units of ``sweep_unit`` codes."""

    index: Ints
    b_z: Ints
    b_xy: Ints


def sweep_unit(design: Design) -> int:
    """Integer value of one converter code (of the normalised frame) in B^z and B^xy."""
    return 4 * design.search.steps << design.formats.vector_fraction


def tolerance(design: Design) -> Ints:
    """Plateau tolerance in the units of B^z for every exponent ``(adc bits,)``, limited to the longest B^z."""
    exact = round(design.search.tolerance * sweep_unit(design))
    longest = (1 << design.widths.b_z) - 1
    return np.array([min(exact << e, longest) for e in range(design.adc.bits)], dtype=np.int64)


def sweep(design: Design, stress: Ints, p: Ints, q: Ints, negative: Bools, exponent: Ints) -> Sweep:
    """Sweep normalised ``stress``, ``p``, ``q``, all ``(n, m)``; p and q carry the factor 4.

    The winner has the smallest B^xy among the candidates within the tolerance of the smallest B^z, and is the
    first of those in sweep order.
    """
    steps = design.search.steps
    x = steps * (p - np.where(negative[:, None], q, 0))
    b_z = positive_sums(x, q, design.candidates)
    b_xy = positive_sums(sweep_unit(design) * stress - x, -q, design.candidates)
    measured = sweep_unit(design) * np.maximum(stress, 0).sum(axis=1)
    b_xy = np.abs(b_xy - measured[:, None])
    limit = b_z.min(axis=1) + tolerance(design)[exponent]
    index = np.where(b_z <= limit[:, None], b_xy, np.iinfo(np.int64).max).argmin(axis=1)
    return Sweep(index, b_z, b_xy)


def positive_sums(first: Ints, step: Ints, count: int) -> Ints:
    """Sum over taxels of max(0, first + k * step) for k = 0 ... count - 1, shape ``(n, count)``, exact.

    Every term changes its sign once at most, so it counts from, or up to, one k; the terms that count at k are the
    running sum of those that come and go: m + count steps for a frame instead of m * count.
    """
    size, falling = np.abs(step), step <= 0
    change = np.where(falling, -(-first // np.maximum(size, 1)), -first // np.maximum(size, 1) + 1)
    change = np.where(size == 0, np.where(first > 0, count, 0), np.clip(change, 0, count))
    rows = np.arange(len(first))[:, None] * (count + 1)
    sign = np.where(falling, -1, 1)
    totals = []
    for term in (first, step):
        flat = np.zeros(len(first) * (count + 1), dtype=np.int64)
        np.add.at(flat, (rows + change).ravel(), (sign * term).ravel())
        come = flat.reshape(len(first), count + 1)
        come[:, 0] += np.where(falling, term, 0).sum(axis=1)
        totals.append(np.cumsum(come[:, :count], axis=1))
    return np.asarray(totals[0] + np.arange(count) * totals[1])
