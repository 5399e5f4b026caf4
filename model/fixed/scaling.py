"""Scaled forces and resultants as result words (Eq. 31)."""

from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Bools, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import Gain, Resultant
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.numbers import round_shift, saturate


@dataclass(frozen=True)
class Scaled:
    """``forces (n, 3, m)`` and ``resultant (n, 3)`` in result words, and where one was limited ``(n,)``."""

    forces: Ints
    resultant: Ints
    saturated: Bools


def scaling(design: Design, frame: Normalised, gain: Gain, unscaled: Ints, total: Resultant) -> Scaled:
    """Scale ``unscaled (n, 3, m)`` forces and their resultant.

    Frames without traction keep only normal forces; frames without contact keep nothing.
    """
    keep = np.stack([frame.regular, frame.regular, frame.contact], axis=1)
    bits = design.widths.output
    mantissa = gain.mantissa[:, None]
    wide = round_shift(unscaled * mantissa[:, :, None], gain.force_shift[:, None, None])
    force = saturate(wide, bits)
    wide_total = round_shift(total.words * mantissa, gain.resultant_shift[:, None])
    resultant = saturate(wide_total, bits)
    limited = ((wide != force).any(axis=2) | (wide_total != resultant)) & keep
    return Scaled(force * keep[:, :, None], resultant * keep, limited.any(axis=1) | (gain.overflow & frame.contact))
