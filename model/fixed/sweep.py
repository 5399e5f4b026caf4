"""The exact integer sweep: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

On the grid mu = kappa / K the numerator K p + kappa q is an integer, so candidates differ by additions of q and
nothing is rounded.  All values carry the factor 4 K of unfolded vectors times the grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.widths import widths
from tfra.model.tfra import Bools

_CHUNK = 256  # frames whose vectors stay in a core's cache


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
    longest = (1 << widths(design).b_z) - 1
    return np.array([min(exact << e, longest) for e in range(design.adc.bits)], dtype=np.int64)


def sweep(design: Design, stress: Ints, p: Ints, q: Ints, negative: Bools, exponent: Ints) -> Sweep:
    """Sweep normalised ``stress``, ``p``, ``q``, all ``(n, m)``; p and q carry the factor 4.

    The winner has the smallest B^xy among the candidates within the tolerance of the smallest B^z, and is the
    first of those in sweep order.
    """
    count, steps = len(stress), design.search.steps
    b_z = np.empty((count, design.candidates), dtype=np.int64)
    b_xy = np.empty_like(b_z)
    for start in range(0, count, _CHUNK):
        part = slice(start, start + _CHUNK)
        x = steps * (p[part] - np.where(negative[part, None], q[part], 0))
        _positive_sums(x, q[part], b_z[part])
        _positive_sums(sweep_unit(design) * stress[part] - x, -q[part], b_xy[part])
    measured = sweep_unit(design) * np.maximum(stress, 0).sum(axis=1)
    b_xy = np.abs(b_xy - measured[:, None])
    limit = b_z.min(axis=1) + tolerance(design)[exponent]
    index = np.where(b_z <= limit[:, None], b_xy, np.iinfo(np.int64).max).argmin(axis=1)
    return Sweep(index, b_z, b_xy)


def _positive_sums(first: Ints, step: Ints, out: Ints) -> None:
    """``out[:, k]`` = sum over taxels of max(0, first + k * step)."""
    x, positive = first.copy(), np.empty_like(first)
    ones = np.ones(first.shape[1], dtype=np.int64)
    for k in range(out.shape[1]):
        np.maximum(x, 0, out=positive)
        np.einsum("ij,j->i", positive, ones, out=out[:, k])
        x += step
