"""The folded, quantised operators: what the coefficient memories hold, and the order of the products.

With x^ = fold(x), every operator that commutes with the mirrors maps parity to parity, so its folded form is
four ``Q x Q`` blocks.  Stacks group the operators that share an operand:

    contact   b^ -> w = C33^-1 b,  and the sums of A-dagger b
    residual  n^ -> the sums of A-dagger d plus w,  and g = C33 n, d1 = -C31 n, d2 = -C32 n
    normal    e^ -> C33 A3-dagger e                 (twice: e0, then e1)
    force     d^ -> A1-dagger d, A2-dagger d, A3-dagger d

That is the form ``pinv``.  The form ``gram`` stores G = (A A^T)^-1 in place of the three A-dagger = A^T G:

    gram      d^ -> y = G d
    force     y^ -> C31^T y, C32^T y, C33^T y

C31 and C32 change sign when taxel and force change places, C33 does not, so these are the operators of the residual
product: the force product reads them there, behind the sums.

Sums are the A_pq of Eq. 12, one row each: the rows of a quad of sums work on the four parities.  Matrices are
dimensionless (C times h^2, A-dagger over h^2); a coefficient is worth its integer over ``2^fraction``, with the
largest fraction that the words of its operator allow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, log2

import numpy as np

from tfra.model.boussinesq import gram_inverse, operators
from tfra.model.design import Design
from tfra.model.fixed.butterfly import EE, HADAMARD, OO, OX, OY, distinct, taxel_index
from tfra.model.fixed.numbers import Ints
from tfra.model.sensor import Floats
from tfra.model.sparse import filtered


@dataclass(frozen=True, eq=False)
class Operator:
    """One quantised operator in folded form.

    ``rows (n, 4, Q)``: row (i, parity) of result quad i; it multiplies the operand's parity ``parity ^ flip``.
    A coefficient is worth ``rows / 2^fraction``.  ``gain`` bounds |result| / |operand| in the taxel domain,
    ``folded_gain`` in the parity domain.
    """

    name: str
    rows: Ints
    flip: int
    fraction: int
    gain: float
    folded_gain: float

    @property
    def quads(self) -> int:
        """Result quads."""
        return len(self.rows)


@dataclass(frozen=True, eq=False)
class Stack:
    """Operators that share an operand, computed in order."""

    name: str
    operators: tuple[Operator, ...]

    @property
    def quads(self) -> int:
        """Result quads of the whole stack."""
        return sum(op.quads for op in self.operators)


STACKS = ("contact", "residual", "normal", "force")
PRODUCTS = ("contact", "residual", "normal", "normal", "force")
"""The products of a frame in order: b^, n^, e0^, e1^, d^."""


def stored(design: Design) -> tuple[str, ...]:
    """The stacks with coefficients of their own, in the order of the memories."""
    return STACKS if design.operators == "pinv" else ("contact", "residual", "normal", "gram")


def products(design: Design) -> tuple[str, ...]:
    """The stack of each product of a frame, in order."""
    return PRODUCTS if design.operators == "pinv" else (*PRODUCTS[:-1], "gram", "force")


def multiplications(design: Design) -> int:
    """Real products of a frame."""
    return sum(4 * stacks(design)[name].quads * design.quads for name in PRODUCTS)


@lru_cache(maxsize=4)
def _fold_matrix(design: Design) -> tuple[Floats, Floats]:
    """fold ``(4Q, m)`` and unfold ``(m, 4Q)`` as matrices, with ``unfold @ fold = identity``."""
    index, m = taxel_index(design), design.sensor.taxels
    fold = np.zeros((design.quads, 4, m))
    unfold = np.zeros((m, design.quads, 4))
    count = distinct(design).sum(axis=1)
    for quad, places in enumerate(index):
        for place, taxel in enumerate(places):
            fold[quad, :, taxel] += HADAMARD[:, place]
            unfold[taxel, quad] += HADAMARD[:, place] * count[quad] / 16
    return fold.reshape(-1, m), unfold.reshape(m, -1)


def _serpentine(design: Design) -> Ints:
    """Quads in an order in which neighbours follow each other: rows of the folded array, to and fro."""
    grid = np.arange(design.quads).reshape(design.quad_rows, design.quad_columns)
    grid[1::2] = grid[1::2, ::-1].copy()
    return grid.ravel()


def quantise_rows(design: Design, rows: Floats) -> tuple[Ints, int]:
    """Coefficients ``(..., Q)`` as integers, and their fraction bits.

    Not each coefficient but the running sum along a row is rounded to nearest: an error is made up for by the next
    neighbour, so errors cancel for operands that are smooth over the array, as stress is.  A coefficient differs from
    its exact value by one at most, which leaves it a place in its word.
    """
    largest = np.abs(rows).max()
    fraction = int(np.floor(np.log2(((1 << (design.formats.coefficient - 1)) - 2) / largest)))
    order = _serpentine(design)
    running = np.rint(np.cumsum(rows[..., order] * 2.0**fraction, axis=-1))
    words = np.empty(rows.shape, dtype=np.int64)
    words[..., order] = np.diff(running, axis=-1, prepend=0.0)
    return words, fraction


def _matrix_operator(design: Design, name: str, matrix: Floats, flip: int) -> Operator:
    fold, unfold = _fold_matrix(design)
    q = design.quads
    folded = (fold @ matrix @ unfold).reshape(q, 4, q, 4)
    parity = np.arange(4)
    rows, fraction = quantise_rows(design, np.moveaxis(folded[:, parity, :, parity ^ flip], 0, 1))  # (i, parity, j)
    bare = Operator(name, rows, flip, fraction, 0.0, _row_sum(rows) / 2.0**fraction)
    return replace(bare, gain=_row_sum(taxel_matrix(design, bare)))


def taxel_matrix(design: Design, op: Operator) -> Floats:
    """What the quantised ``op`` does to taxels, unfolded: ``(m, m)``, dimensionless."""
    fold, unfold = _fold_matrix(design)
    q, parity = design.quads, np.arange(4)
    exact = np.zeros((q, 4, q, 4))
    exact[:, parity, :, parity ^ op.flip] = np.moveaxis(op.rows, 1, 0) / 2.0**op.fraction
    return np.asarray(unfold @ exact.reshape(4 * q, 4 * q) @ fold)


def _sum_operator(design: Design, name: str, functionals: list[dict[int, Floats]]) -> Operator:
    """Rows that sum: one quad per dict, which maps a parity to the functional ``(m,)`` of that parity."""
    _, unfold = _fold_matrix(design)
    exact = np.zeros((len(functionals), 4, design.quads))
    for quad, by_parity in enumerate(functionals):
        for parity, functional in by_parity.items():
            exact[quad, parity] = (functional @ unfold).reshape(-1, 4)[:, parity]
    rows, fraction = quantise_rows(design, exact)
    gain = _row_sum(rows) / 2.0**fraction
    return Operator(name, rows, 0, fraction, 4 * gain, gain)


def _row_sum(rows: Floats | Ints) -> float:
    return float(np.abs(rows).sum(axis=-1).max())


@lru_cache(maxsize=16)
def stacks(design: Design) -> dict[str, Stack]:
    """Every stack of ``design``, by name; cached."""
    ops, h2 = operators(design.sensor), design.sensor.thickness**2
    if design.sparse:
        ops = filtered(ops, design.sparse)
    c31, c32, c33 = ops.c31 * h2, ops.c32 * h2, ops.c33 * h2
    pinv = ops.pinv1 / h2, ops.pinv2 / h2, ops.pinv3 / h2
    s1, s2, s3 = (p.sum(axis=0) for p in pinv)
    one = np.ones(design.sensor.taxels)
    sums_n = [
        {EE: one - s1 @ c31, OX: s1 @ c33, OY: s2 @ c33, OO: -s1 @ c32},  # A11, A10, A20, A12
        {EE: one - s2 @ c32, OX: -s3 @ c31, OY: -s3 @ c32, OO: -s2 @ c31},  # A22, A31, A32, A21
        {EE: s3 @ c33 - one},  # A30
    ]
    sums_b = [{EE: s3, OX: s1, OY: s2}]  # A30, A10, A20

    def matrix(name: str, values: Floats, flip: int = EE) -> Operator:
        return _matrix_operator(design, name, values, flip)

    contact = matrix("c33_inv", ops.c33_inv / h2), _sum_operator(design, "sums_b", sums_b)
    residual = matrix("c33", c33), matrix("c31", -c31, OX), matrix("c32", -c32, OY)
    sums = _sum_operator(design, "sums_n", sums_n)
    # The sums come first, so that alpha and beta are found while the vectors are still on their way.
    groups: dict[str, tuple[Operator, ...]] = {"contact": contact, "residual": (sums, *residual)}
    groups["normal"] = (matrix("normal", c33 @ pinv[2]),)
    if design.operators == "pinv":
        groups["force"] = matrix("pinv1", pinv[0], OX), matrix("pinv2", pinv[1], OY), matrix("pinv3", pinv[2])
    else:
        transposed = *residual[1:], residual[0]
        groups["residual"] = sums, *transposed
        # y is longer than d: a scale keeps its words as short as those of the forces
        gram = gram_inverse(design.sensor) / h2**2
        scale = max(0, ceil(log2(_row_sum(gram) / max(_row_sum(p) for p in pinv))))
        groups["gram"] = (matrix("gram", gram / 2**scale),)
        groups["force"] = tuple(_scaled(op, scale) for op in transposed)
    return {name: Stack(name, group) for name, group in groups.items()}


def _scaled(op: Operator, scale: int) -> Operator:
    """``op`` times ``2^scale``, with the same words."""
    gain, folded_gain = (g * 2**scale for g in (op.gain, op.folded_gain))
    return replace(op, name=f"{op.name}_transposed", fraction=op.fraction - scale, gain=gain, folded_gain=folded_gain)


def split(design: Design, stack: str, results: Ints) -> dict[str, Ints]:
    """Result quads ``(n, quads, 4)`` of a product by the name of their operator."""
    group = stacks(design)[stack].operators
    parts = np.split(results, np.cumsum([op.quads for op in group])[:-1], axis=1)
    return {op.name: part for op, part in zip(group, parts, strict=True)}


def coefficient_bits(design: Design) -> int:
    """Bits of all coefficients, each stored once."""
    words = sum(op.rows.size for name in stored(design) for op in stacks(design)[name].operators)
    return int(words) * design.formats.coefficient


def kinds(design: Design) -> tuple[str, ...]:
    """Names of all operators, stack by stack: what a result can be a result of."""
    return tuple(op.name for name in STACKS for op in stacks(design)[name].operators)


def nonzero_products(design: Design) -> int:
    """Products of a frame whose coefficient is not zero."""
    rows = [op.rows for name in products(design) for op in stacks(design)[name].operators]
    return int(sum(np.count_nonzero(r) for r in rows))
