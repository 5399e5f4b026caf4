"""Word lengths of a core; an estimator's ``bounds`` prove how many bits each quantity needs.

All vectors live on one grid: one LSB is ``2^-vector_fraction`` of a converter code of the normalised frame.  Since no
vector can overflow its word, only the result words and one scalar can saturate.
"""

from __future__ import annotations

from dataclasses import dataclass

from tfra.model.choices import Choices

MU_LIMIT = 4
"""Scalars (alpha, beta, mu_x, mu_y) lie in [-4, 4)."""


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


def force_drop(choices: Choices) -> int:
    """Bits below the vector grid times four that unscaled forces do not keep: two beyond the result's own."""
    return max(0, choices.formats.vector_fraction - choices.formats.force_fraction)
