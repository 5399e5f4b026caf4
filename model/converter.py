"""The converter behind every taxel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.choices import Choices
from tfra.model.tfra import check_frames


def quantise(choices: Choices, frames: npt.ArrayLike) -> Ints:
    """Converter codes ``(n, rows, columns)`` of ``frames`` in Pa, rounded to nearest.

    Raises ``ValueError`` naming the first taxel that is not finite or over full scale.
    """
    stress = check_frames(choices.sensor, frames)
    codes = np.rint(stress / choices.adc.lsb)
    limit = 1 << (choices.adc.bits - 1)
    bad = np.argwhere((codes < -limit) | (codes > limit))
    if len(bad):
        frame, row, column = bad[0]
        raise ValueError(
            f"frames: frame {frame}, row {row}, column {column} is {stress[tuple(bad[0])]:.6g} Pa, "
            f"over the full scale of {choices.adc.full_scale:.6g} Pa"
        )
    return np.minimum(codes, limit - 1).astype(np.int64)
