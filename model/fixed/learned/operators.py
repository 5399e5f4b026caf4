"""The operators of the learned estimator and the order of its products.

Stacks group the operators that share an operand:

    first   b^  -> the first layer, the part of the outputs that is linear in b, and -K b for the field
    second  h1^ -> the second layer, and its part of the outputs
    read    h2^ -> its part of the outputs
    field   p^  -> K G_x p and K G_y p

K is the inverse of the normal influence G_z (:mod:`tfra.model.learned.field`).  The outputs are two quads: F_z, F_x and
F_y in the parities that they read, and the uncertainty.  A quarter in every operator in front of an activation undoes
the factor of its butterfly.
"""

from typing import NamedTuple

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.choices import Choices
from tfra.model.fixed.butterfly import EE, HADAMARD, OX, OY
from tfra.model.fixed.coefficients import Folding, Operator, Stack, nearest_rows, quantise_rows, stacked
from tfra.model.learned.field import influence
from tfra.model.learned.network import MIRRORS, NAMES, Folded, Weights, fold
from tfra.model.sensor import SensorArray

OPERATORS = {
    "first": ("first", "direct", "inverse"),
    "second": ("second", "read1"),
    "read": ("read2",),
    "field": ("shear_x", "shear_y"),
}
"""Names of the operators of each stack, in the order of the coefficient memories."""

FINER = 3
"""Bits above those of b: the terms of a unit cancel, so it is far smaller than it might be, and needs a finer grid."""

LONG = 18
"""Bits of coefficients that are enough for units of one range; shorter ones have to fill their words."""

OF_FORCES = ("inverse", *OPERATORS["field"])
"""Operators that only the forces at the taxels need."""

PLACES = ((0, OX), (0, OY), (0, EE), (1, EE))
"""Quad and parity of every output: the resultant in the first quad, the uncertainty in the second."""


def names(taxel_forces: bool) -> dict[str, tuple[str, ...]]:
    """Names of the operators of each stack of a design with or without forces at the taxels."""
    needed = {
        stack: tuple(name for name in all_names if taxel_forces or name not in OF_FORCES)
        for stack, all_names in OPERATORS.items()
    }
    return {stack: names for stack, names in needed.items() if names}


def make_stacks(choices: Choices, weights: Weights, taxel_forces: bool) -> dict[str, Stack]:
    """Every stack by its name, in the order of ``OPERATORS``."""
    quantised = [_operator(choices, name, each) for name, each in network_rows(choices, weights).items()]
    if taxel_forces:
        folding = Folding(choices)
        quantised += [folding.matrix(name, *each) for name, each in field_matrices(choices.sensor).items()]
    return stacked(choices, quantised, names(taxel_forces))


def network_rows(choices: Choices, weights: Weights) -> dict[str, Floats]:
    """The network's operators by name, as the rows of :func:`balanced`."""
    return dict(zip(NAMES, balanced(choices, fold(choices, weights)).rows, strict=True))


def field_matrices(sensor: SensorArray) -> dict[str, tuple[Floats, int]]:
    """The operators ``OF_FORCES`` by name: matrices ``(m, m)``, and the parity that each flips."""
    g = influence(sensor)
    return {
        "inverse": (-g.inverse / sensor.taxel_area / MIRRORS, EE),
        "shear_x": (g.inverse @ g.x / MIRRORS, OX),
        "shear_y": (g.inverse @ g.y / MIRRORS, OY),
    }


class Balanced(NamedTuple):
    """The network as ``rows (n, 4, K)`` of operators; units of the layers are smaller by ``first`` and ``second``."""

    rows: Folded[Floats]
    first: Floats
    second: Floats


def balanced(choices: Choices, folded: Folded[Floats]) -> Balanced:
    """The network as rows of operators, with each layer's units brought to about the same range.

    A unit of a layer can be made smaller and its weights in the next layers larger, without another result.  Here all
    units share one grid: those of the first layer exceed a word of b by ``FINER`` bits at most, those of the second do
    not exceed the first's.
    """
    bits = choices.formats.bits
    first, second = np.moveaxis(folded.first, -1, 0), np.moveaxis(folded.second, -1, 0)
    size1 = _unit_sizes(first, bits("coefficient.first"), 2.0**FINER)
    second = second * size1
    size2 = _unit_sizes(second, bits("coefficient.second"), 1.0)
    reads = (output_rows(read) for read in (folded.read2 * size2, folded.read1 * size1, folded.direct))
    rows = Folded(first / size1[:, None, None], second / size2[:, None, None], *reads)
    return Balanced(rows, size1, size2)


def rounded(choices: Choices, folded: Folded[Floats]) -> Balanced:
    """The same, with coefficients that words of their length can stand for."""
    exact = balanced(choices, folded)
    words = (_words(choices, name, rows) for name, rows in zip(NAMES, exact.rows, strict=True))
    return exact._replace(rows=Folded(*(rows / 2.0**fraction for rows, fraction in words)))


def _unit_sizes(rows: Floats, bits: int, most: float) -> Floats:
    """What divides each of ``rows (n, 4, K)``, coefficients of ``bits``, so that no unit exceeds ``most``.

    Long words allow for units of one range.  In short ones the largest coefficient of each unit fills its word, within
    as many bits as the word is shorter than ``LONG``; the last factor of ``full`` keeps quotients from exceeding it.
    """
    gain, full = unit_gain(rows), (1 - 2.0 ** (2 - bits)) * (1 - 1e-9)
    size = np.maximum(np.abs(rows).max(axis=(1, 2)) / full, gain / 2.0 ** max(0, LONG - bits))
    return np.asarray(size * 2.0 ** np.ceil(np.log2((gain / size).max() / most)))


def unit_gain(rows: Floats | Ints) -> Floats:
    """Largest magnitude ``(n,)`` of a mirror's word, for operands whose taxels do not exceed one; ``rows (n, 4, K)``.

    Zero rows have the gain one.
    """
    gain = np.abs(np.einsum("npk,pt->nkt", rows, HADAMARD)).sum(axis=(1, 2))
    return np.where(gain > 0, gain, 1.0)


def output_rows(read: Floats) -> Floats:
    """Rows ``(2, 4, K)`` of two quads from those of the outputs, ``(4, K)``."""
    rows = np.zeros((1 + max(quad for quad, _ in PLACES), MIRRORS, read.shape[1]))
    for (quad, parity), row in zip(PLACES, read, strict=True):
        rows[quad, parity] = row
    return rows


def outputs(quads: Ints) -> Ints:
    """The outputs ``(n, 4)`` in two quads ``(n, 2, 4)``."""
    return np.stack([quads[:, quad, parity] for quad, parity in PLACES], axis=1)


def _operator(choices: Choices, name: str, rows: Floats) -> Operator:
    """Quantise ``rows``."""
    words, fraction = _words(choices, name, rows)
    gain, folded = unit_gain(words).max() / MIRRORS, np.abs(words).sum(axis=-1).max()
    return Operator(name, words, EE, fraction, float(gain) / 2.0**fraction, float(folded) / 2.0**fraction)


def _words(choices: Choices, name: str, rows: Floats) -> tuple[Ints, int]:
    """Coefficient words, in the order of the array where the operand is a vector over it, and their fraction bits."""
    bits, over_array = choices.formats.bits(f"coefficient.{name}"), name in OPERATORS["first"]
    return quantise_rows(choices, rows, bits) if over_array else nearest_rows(rows, bits)
