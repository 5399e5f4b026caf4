"""The converter behind every taxel."""

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Ints
from tfra.model.choices import Choices
from tfra.model.tfra import check_frames


def quantise(choices: Choices, frames: npt.ArrayLike) -> Ints:
    """Converter codes ``(n, rows, columns)`` of ``frames`` in Pa, rounded to nearest.

    Raises ``ValueError`` naming the first taxel that is not finite or over full scale.
    """
    stress = check_frames(choices.sensor, frames)
    limit = 1 << (choices.adc.bits - 1)
    bad = np.argwhere(np.abs(np.rint(stress / choices.adc.lsb)) > limit)
    if len(bad):
        frame, row, column = bad[0]
        raise ValueError(
            f"frames: frame {frame}, row {row}, column {column} is {stress[tuple(bad[0])]:.6g} Pa, "
            f"over the full scale of {choices.adc.full_scale:.6g} Pa"
        )
    return convert(choices, stress)


def convert(choices: Choices, frames: npt.ArrayLike) -> Ints:
    """The same for frames of any stress: values beyond full scale are clipped, as by a converter.

    :func:`saturated` tells which frames.  Raises ``ValueError`` naming the first taxel that is not finite.
    """
    limit = 1 << (choices.adc.bits - 1)
    codes = np.rint(check_frames(choices.sensor, frames) / choices.adc.lsb)
    return np.clip(codes, -limit, limit - 1).astype(np.int64)


def saturated(choices: Choices, codes: Ints) -> Bools:
    """Which frames of ``codes (n, ...)`` have a code at an end of its range, ``(n,)``."""
    top = (1 << (choices.adc.bits - 1)) - 1
    return np.asarray(((codes >= top) | (codes <= -top - 1)).any(axis=tuple(range(1, codes.ndim))))
