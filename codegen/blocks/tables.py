"""The tables that the sources of the blocks read."""

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.butterfly import taxel_index
from tfra.model.fixed.cordic import angle_table
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import signed_bits
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.sweep import tolerance
from tfra.model.fixed.widths import mu_grid

_LINE = 108
"""Characters of a line of numbers."""


@dataclass(frozen=True, eq=False)
class Table:
    """``values`` in words of ``bits``, signed, under the ``name`` that the sources use."""

    name: str
    values: Ints
    bits: int
    text: str


def tables(design: Design) -> list[Table]:
    """All tables of ``design``: places, angles, candidates, then the operators in the order of their stacks."""
    index = taxel_index(design)
    _, first = np.unique(index.ravel(), return_index=True)
    quad, plane = np.divmod(first, 4)
    found = [
        _table("TAXEL_OF", index.T.ravel(), "taxel of every word of a vector in the taxel domain"),
        _table("PLACE_OF", plane * design.quads + quad, "place of every taxel in such a vector"),
        _table("ANGLE_TABLE", np.array(angle_table(design)), "atan(2^-i) in 2^-(CORDIC + ANGLE_GUARD) turns"),
    ]
    if isinstance(design, TfraDesign):
        found += [
            _table("MU_GRID", mu_grid(design), "mu = k / STEPS as a scalar"),
            _table("TOLERANCE", tolerance(design), "tolerance of B^z for every exponent"),
        ]
    word = max(signed_bits(int(np.abs(op.rows).max())) for stack in design.stacks.values() for op in stack.operators)
    for stack in design.stacks.values():
        for op in stack.operators:
            quads, _, count = op.rows.shape
            text = f"operator {op.name}: {count} coefficients for each of {quads} results, in the four parities"
            found.append(Table(op.name.upper(), np.moveaxis(op.rows, 1, 0).ravel(), word, text))
    return found


def _table(name: str, values: Ints, text: str) -> Table:
    return Table(name, values, signed_bits(int(np.abs(values).max())), text)


def numbers(values: Iterable[int]) -> str:
    """Lines of an initialiser in C."""
    return textwrap.fill(", ".join(map(str, values)), _LINE, initial_indent="    ", subsequent_indent="    ")
