"""Bounds on the direction words of TFRA and on phi."""

from fractions import Fraction

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.fixed.numbers import block_normalize, significant_bits
from tfra.model.fixed.tfra.centroids import moments, offset, pitch_ratio
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.study.bounds.slack import filled


def direction_slack(design: TfraDesign, trace: Trace) -> Floats:
    """How far ``cos`` and ``sin`` are from a multiple of the exact direction, in their last bits, ``(n, 2)``.

    The offset is exact; it is rounded to the words of a division, times the pitch, and rounded again.
    """
    exact, ratio = offset(*moments(design, trace.codes)), np.array(pitch_ratio(design))
    bits, word = design.widths.division, design.formats.bits("direction")
    significant = significant_bits(exact, axis=1)[:, None]
    first = significant - (bits - 1)
    length = block_normalize(exact, significant, bits) * ratio
    second = significant_bits(length, axis=1)[:, None] - (word - 1)
    slack = filled(exact, 1, bits) * 2.0**-first * ratio + filled(length, 1, word)
    slack *= 2.0**-second
    true = Fraction(design.sensor.pitch_x) / Fraction(design.sensor.pitch_y)
    off = abs(float(Fraction(int(ratio[0]), int(ratio[1])) / true - 1))
    words = np.stack([trace.direction.cos, trace.direction.sin], axis=1)
    slack += (np.abs(words) + slack) * off * np.array([design.sensor.pitch_x < design.sensor.pitch_y, design.sensor.pitch_x >= design.sensor.pitch_y])
    return np.where(trace.direction.vanishing[:, None], 0.0, slack)
