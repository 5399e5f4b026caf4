"""Folded, quantised operators: the contents of the coefficient memories.

With x^ = fold(x), every operator that commutes with the mirrors maps parity to parity, so its folded form is four
``Q x Q`` blocks.  Matrices are dimensionless (C times h^2, A-dagger over h^2); a coefficient is worth its integer over
``2^fraction``, with the largest fraction that the words of its operator allow.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Choices
from tfra.model.fixed.butterfly import EE, HADAMARD, distinct, taxel_index


@dataclass(frozen=True, eq=False)
class Operator:
    """One quantised operator in folded form.

    ``rows (n, 4, K)``: row (i, parity) of result quad i; it multiplies the operand's parity ``parity ^ flip``.  The
    operand has K quads: Q if it is a vector over the array.
    A coefficient is worth ``rows / 2^fraction``; one that is shorter than a lane's ends in zeros.  ``gain`` bounds
    |result| / |operand| in the taxel domain, ``folded_gain`` in the parity domain.
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

    @property
    def row_sum(self) -> int:
        """Largest sum of a row's magnitudes: the exact sum of a product is as many times its largest operand word."""
        return int(np.abs(self.rows).sum(axis=-1).max())


@dataclass(frozen=True, eq=False)
class Stack:
    """Operators that share an operand, computed in order."""

    name: str
    operators: tuple[Operator, ...]

    @property
    def quads(self) -> int:
        """Result quads of the whole stack."""
        return sum(op.quads for op in self.operators)

    @property
    def operand_quads(self) -> int:
        """Quads of the operand, the same for all operators."""
        return int(self.operators[0].rows.shape[-1])

    def split(self, results: Ints) -> dict[str, Ints]:
        """Result quads ``(n, quads, 4)`` of a product by the name of their operator."""
        parts = np.split(results, np.cumsum([op.quads for op in self.operators])[:-1], axis=1)
        return {op.name: part for op, part in zip(self.operators, parts, strict=True)}


def stacked(choices: Choices, operators: Sequence[Operator], names: Mapping[str, Sequence[str]]) -> dict[str, Stack]:
    """Stacks by their names; ``names`` are those of each stack's ``operators`` in order.

    Shorter coefficients are aligned to the top of a lane's word.
    """
    lengths = {op.name: choices.formats.bits(f"coefficient.{op.name}") for op in operators}
    word = max(lengths.values())
    zeros = {name: word - bits for name, bits in lengths.items()}
    by_name = {
        op.name: replace(op, rows=op.rows << zeros[op.name], fraction=op.fraction + zeros[op.name]) for op in operators
    }
    return {stack: Stack(stack, tuple(by_name[name] for name in members)) for stack, members in names.items()}


class Folding:
    """The butterfly of an array as matrices: ``fold (4Q, m)`` and ``unfold (m, 4Q)``, ``unfold @ fold = identity``."""

    def __init__(self, choices: Choices) -> None:
        self._choices, m = choices, choices.sensor.taxels
        fold = HADAMARD @ (taxel_index(choices)[:, :, None] == np.arange(m)).astype(np.float64)
        unfold = fold * (distinct(choices).sum(axis=1)[:, None, None] / 16)
        self.fold, self.unfold = fold.reshape(-1, m), unfold.transpose(2, 0, 1).reshape(m, -1)

    def matrix(self, name: str, matrix: Floats, flip: int = EE) -> Operator:
        """Quantise ``matrix (m, m)``, which maps each parity p to p ^ ``flip``."""
        bits = self._choices.formats.bits(f"coefficient.{name}")
        rows, fraction = quantise_rows(self._choices, self.rows(matrix, flip), bits)
        bare = Operator(name, rows, flip, fraction, 0.0, _row_sum(rows) / 2.0**fraction)
        return replace(bare, gain=_row_sum(self.taxel_matrix(bare)))

    def rows(self, matrix: Floats, flip: int = EE) -> Floats:
        """The folded ``matrix (m, m)`` as rows ``(Q, 4, Q)`` of an operator, not quantised."""
        q, parity = self._choices.quads, np.arange(4)
        folded = (self.fold @ matrix @ self.unfold).reshape(q, 4, q, 4)
        return np.moveaxis(folded[:, parity, :, parity ^ flip], 0, 1)

    def sums(self, name: str, functionals: Sequence[dict[int, Floats]]) -> Operator:
        """Quantise rows that sum: one quad per dict, which maps a parity to the functional ``(m,)`` of that parity."""
        exact = np.zeros((len(functionals), 4, self._choices.quads))
        for quad, by_parity in enumerate(functionals):
            for parity, functional in by_parity.items():
                exact[quad, parity] = (functional @ self.unfold).reshape(-1, 4)[:, parity]
        rows, fraction = quantise_rows(self._choices, exact, self._choices.formats.bits(f"coefficient.{name}"))
        gain = _row_sum(rows) / 2.0**fraction
        return Operator(name, rows, 0, fraction, 4 * gain, gain)

    def taxel_matrix(self, op: Operator) -> Floats:
        """The quantised ``op`` in the taxel domain, unfolded: ``(m, m)``, dimensionless."""
        q, parity = self._choices.quads, np.arange(4)
        exact = np.zeros((q, 4, q, 4))
        exact[:, parity, :, parity ^ op.flip] = np.moveaxis(op.rows, 1, 0) / 2.0**op.fraction
        return np.asarray(self.unfold @ exact.reshape(4 * q, 4 * q) @ self.fold)


def quantise_rows(choices: Choices, rows: Floats, bits: int) -> tuple[Ints, int]:
    """Coefficients ``(..., Q)`` as integers of ``bits``, and their fraction bits.

    The running sum along a row is rounded to nearest instead of each coefficient: the next neighbour compensates an
    error, so errors cancel for operands that are smooth over the array, as stress is.  A coefficient differs from its
    exact value by at most one, so it fits its word.
    """
    grid = np.arange(choices.quads).reshape(choices.quad_rows, choices.quad_columns)
    grid[1::2] = grid[1::2, ::-1].copy()  # rows of the folded array, to and fro: neighbours follow each other
    fraction, order = most_fraction(rows, bits), grid.ravel()
    running = np.rint(np.cumsum(rows[..., order] * 2.0**fraction, axis=-1))
    words = np.empty(rows.shape, dtype=np.int64)
    words[..., order] = np.diff(running, axis=-1, prepend=0.0)
    return words, fraction


def nearest_rows(rows: Floats, bits: int) -> tuple[Ints, int]:
    """The same for coefficients whose neighbours multiply words that have nothing to do with each other."""
    fraction = most_fraction(rows, bits)
    return np.rint(rows * 2.0**fraction).astype(np.int64), fraction


def most_fraction(rows: Floats, bits: int) -> int:
    """Most fraction bits with which ``rows`` fit words of ``bits``, each one less than one unit off."""
    largest = float(np.abs(rows).max()) or 1.0
    return int(np.floor(np.log2(((1 << (bits - 1)) - 2) / largest)))


def _row_sum(rows: Floats | Ints) -> float:
    return float(np.abs(rows).sum(axis=-1).max())
