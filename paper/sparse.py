"""Sparse operators: filters F1, F2 and F3 of SpTFRA, doi:10.3390/s24237829, on the precomputed matrices.

A filter sets entries to zero so that hardware need neither store nor multiply them.  :class:`SparseDesign` is a design
with filtered operators.  A filter works on all seven matrices
of :class:`Operators`, each on its own; C33 A3-dagger, which the sweep applies to e0 and e1, follows from the two
filtered factors, and so do the column sums of Eq. 12.  ``Tfra(sensor, ops=filtered(...))`` runs the same algorithm.

Filtered operators no longer satisfy A A-dagger = I, so f reproduces the measured stress only nearly and
b - C33 f_z is no longer C31 f_x + C32 f_y (Eq. 24).  TFRA keeps using b - C33 f_z: it is the traction that the normal
forces do not explain, needs no further matrix, and is what the hardware computes.
"""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.boussinesq import Operators
from tfra.model.fixed.tfra.design import TfraDesign

Kind = Literal["F1", "F2", "F3"]

ROUNDING = 1e-9
"""Entries this close (relative) to a threshold reach it: mirror taxels differ by rounding and stay together."""


@dataclass(frozen=True, slots=True)
class Filter:
    """The entries of each matrix row that a filter keeps.

    ====  ====================================================================================================
    F1    the non-zero entries nearest the diagonal in row-major order: ``strength`` % of the row, at least one
    F2    the entries of at least ``strength`` % of the row's largest magnitude
    F3    as F2, or as many entries nearest the diagonal, spread evenly over the rows: whichever has the
          smaller Frobenius error, for each matrix on its own; F2 if equal
    ====  ====================================================================================================

    F1 keeps everything at 100, F2 and F3 at 0.  Of two entries equally far from the diagonal F1 takes the left one.
    Raises ``ValueError`` naming the field for another kind or a strength outside [0, 100].
    """

    kind: Kind
    strength: float

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise ValueError(f"kind: one of {', '.join(get_args(Kind))} is needed, got {self.kind!r}")
        if not 0 <= self.strength <= 100:
            raise ValueError(f"strength: 0 to 100 % is needed, got {self.strength}")

    def mask(self, matrix: Floats) -> Bools:
        """True where an entry of ``matrix (rows, columns)`` is kept."""
        if self.kind == "F1":
            count = max(1, round(self.strength / 100 * matrix.shape[1]))
            return _nearest(matrix, np.full(len(matrix), count))
        large = _large(matrix, self.strength)
        if self.kind == "F2":
            return large
        near = _nearest(matrix, (large.sum() + np.arange(len(matrix))) // len(matrix))
        return near if error(matrix, near) < error(matrix, large) else large


@dataclass(frozen=True)
class SparseDesign(TfraDesign):
    """TFRA with the filter ``sparse``; raises ``ValueError`` for one that breaks the mirrors, which fold operators."""

    sparse: Filter = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sparse.kind != "F2":
            raise ValueError("sparse: only F2 keeps the mirror symmetry that operators are folded by")

    @property
    def exact_operators(self) -> Operators:
        """The operators to quantise, filtered; SI."""
        return filtered(super().exact_operators, self.sparse)


def error(matrix: Floats, mask: Bools) -> float:
    """Frobenius norm of the entries of ``matrix`` that ``mask`` drops, both of one shape; in the matrix' unit."""
    return float(np.linalg.norm(matrix[~mask]))


def filtered(ops: Operators, chosen: Filter) -> Operators:
    """``ops`` with every matrix filtered; new, read-only arrays of unchanged shape, unit and memory layout."""
    matrices = {name: np.array(matrix) for name, matrix in vars(ops).items()}
    for matrix in matrices.values():
        matrix[~chosen.mask(matrix)] = 0.0
        matrix.setflags(write=False)
    return Operators(**matrices)


def kept(ops: Operators) -> dict[str, int]:
    """Non-zero entries of each matrix by name; ``normal`` is C33 A3-dagger, whole or as two factors: the fewer."""
    counts = {name: int(np.count_nonzero(matrix)) for name, matrix in vars(ops).items()}
    whole = int(np.count_nonzero(ops.c33 @ ops.pinv3))
    return counts | {"normal": min(whole, counts["c33"] + counts["pinv3"])}


def multiplications(ops: Operators) -> int:
    """Real multiplications of a frame's matrix products in the float form, without mirror folding.

    Each matrix is applied once, C33 A3-dagger twice.  Operations of a few vectors' length are not counted.
    """
    counts = kept(ops)
    return sum(counts.values()) + counts["normal"]


def _nearest(matrix: Floats, count: Ints) -> Bools:
    """The first ``count (rows,)`` non-zero entries of each row by |i - j|."""
    i, j = np.indices(matrix.shape)
    present = matrix != 0
    distance = np.where(present, np.abs(i - j), matrix.size)
    rank = distance.argsort(axis=1, kind="stable").argsort(axis=1)
    return np.asarray(present & (rank < count[:, None]))


def _large(matrix: Floats, percent: float) -> Bools:
    """The non-zero entries of at least ``percent`` % of their row's largest magnitude."""
    size = np.abs(matrix)
    limit = percent / 100 * (1 - ROUNDING) * size.max(axis=1, keepdims=True)
    return np.asarray((size >= limit) & (size > 0))
