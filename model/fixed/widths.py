"""Word lengths of a core; an estimator's ``bounds`` prove how many bits each quantity needs.

All vectors live on one grid: one LSB is ``2^-vector_fraction`` of a converter code of the normalised frame.  Since no
vector can overflow its word, only the result words and one scalar can saturate.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.choices import Choices
from tfra.model.fixed.coefficients import Stack
from tfra.model.fixed.numbers import divide, signed_bits

MU_LIMIT = 4
"""Scalars (alpha, beta, mu_x, mu_y) lie in [-4, 4)."""

LONGEST = 63
"""Bits of the model's integers."""


@dataclass(frozen=True, slots=True)
class Widths:
    """Word lengths in bits, all signed unless said otherwise; the last ones are TFRA's alone, 0 for others."""

    stress: int
    """Normalised taxel stress: as wide as a converter code."""
    vector: int
    """Any folded vector, and any result of a product."""
    accumulator: int
    """Exact sum of one row's products."""
    alignment: int
    """Zeros appended to an accumulator so that its dynamic shift to the vector grid only goes right."""
    force: int
    """Unscaled force of one taxel: TFRA's on the vector grid times four, less ``force_drop`` bits; else on the grid."""
    magnitude: int
    """Unsigned sum of |b| over the normalised frame, in codes."""
    division: int
    """Numerators and denominators of quotients; words of the CORDIC at its entry."""
    output: int
    """Scaled force or resultant in a result word."""
    moment: int = 0
    """Unsigned first moment of the compressed (or stretched) taxels, in codes times taxels."""
    direction: int = 0
    """Exact c - t cleared of its denominators."""
    candidate: int = 0
    """K * (p + mu q) of one taxel, times four."""
    b_z: int = 0
    """Unsigned sum of a candidate's positive parts."""
    b_xy: int = 0
    """Unsigned |sum - sum| of Eq. 25."""


def scalar_fraction(choices: Choices) -> int:
    """Fraction bits of a scalar."""
    return choices.formats.bits("scalar") - 3


def mu_grid(choices: Choices) -> Ints:
    """mu = k / K for k = 0 ... K as scalars, shape ``(K + 1,)``; the negative side is its mirror image."""
    steps = np.arange(choices.candidates)
    return divide(steps, np.int64(choices.search.steps), scalar_fraction(choices))


def force_drop(choices: Choices) -> int:
    """Bits below the vector grid times four that unscaled forces do not keep: two beyond the result's own."""
    return max(0, choices.formats.vector_fraction - choices.formats.force_fraction)


def widths_of(choices: Choices, stacks: Mapping[str, Stack], vector: int, **own: Any) -> Widths:
    """Word lengths of a core whose vectors have ``vector`` bits; ``own`` are those that the estimator proves itself."""
    fmt, adc, m = choices.formats, choices.adc, choices.sensor.taxels
    operators = [o for s in stacks.values() for o in s.operators]
    word = max(fmt.bits(f"operand.{name}") for name in stacks)
    return Widths(
        stress=adc.bits,
        vector=vector,
        accumulator=signed_bits(max(o.row_sum for o in operators) << (word - 1)),
        alignment=max(0, *(vector - word - o.fraction for o in operators)),
        magnitude=(m << (adc.bits - 1)).bit_length(),
        division=fmt.bits("division"),
        output=adc.bits + (m - 1).bit_length() + fmt.force_fraction,
        **own,
    )


def require_exact(widths: Widths, scalar: int, **longest: int) -> None:
    """Raise ``ValueError`` naming ``formats`` for words that the model's integers do not hold.

    They are those of every core, products of a force by words of ``scalar`` bits included, and an estimator's
    ``longest``.
    """
    longest |= {"accumulator": widths.accumulator + widths.alignment + 1, "force": widths.force + scalar + 1}
    for name, bits in longest.items():
        if bits > LONGEST:
            raise ValueError(f"formats: {name} can overflow: {bits} bits are needed, {LONGEST} are supported")
