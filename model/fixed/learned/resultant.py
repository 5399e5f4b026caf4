"""The resultant and its plausibility from the outputs of the network."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.numbers import block_normalize, round_shift, saturate, significant_bits

THRESHOLD_FRACTION, THRESHOLD_BITS = 8, 16
"""Fraction bits and bits of the threshold, which is unsigned."""


@dataclass(frozen=True)
class Judged:
    """``words (n, 3)`` and ``uncertainty (n,)`` in result words; ``limited (n,)``: a word was saturated;
    ``implausible (n,)``: F pulls, or its uncertainty is over the threshold."""

    words: Ints
    uncertainty: Ints
    limited: Bools
    implausible: Bools


def resultant(design: Design, force: Ints) -> Resultant:
    """``force (n, 3)`` on the vector grid, normalised together."""
    significant = significant_bits(force, axis=1)
    bits = design.widths.division
    return Resultant(block_normalize(force, significant[:, None], bits), bits - 1 - significant)


def judged(design: Design, outputs: Ints, threshold: int) -> Judged:
    """``outputs (n, 4)`` of the network as result words, and whether they are plausible."""
    force, uncertainty = outputs[:, :3], np.maximum(outputs[:, 3], 0)
    shift, bits = design.formats.vector_fraction - design.formats.force_fraction, design.widths.output
    wide = round_shift(np.column_stack([force, uncertainty]), shift)
    words = saturate(wide, bits)
    doubtful = (uncertainty << THRESHOLD_FRACTION) > threshold * np.abs(force[:, 2])
    return Judged(words[:, :3], words[:, 3], (wide != words).any(axis=1), (force[:, 2] >= 0) | doubtful)


def threshold_word(threshold: float) -> int:
    """The threshold of the uncertainty over the normal force as a word; the largest one where it is too long."""
    return int(min(np.rint(threshold * 2.0**THRESHOLD_FRACTION), 2**THRESHOLD_BITS - 1))
