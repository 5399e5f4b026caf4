"""The converter behind every taxel."""

from typing import Protocol

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Bools, Ints
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.model.tfra import check_frames


class Measured(Protocol):
    """An array and its converter: a design, or a skin."""

    @property
    def sensor(self) -> SensorArray:
        """All taxels."""

    @property
    def adc(self) -> Adc:
        """The converter of each."""


def quantise(array: Measured, frames: npt.ArrayLike) -> Ints:
    """Converter codes ``(n, rows, columns)`` of ``frames`` in Pa, rounded to nearest.

    Raises ``ValueError`` naming the first taxel that is not finite or over full scale.
    """
    stress = check_frames(array.sensor, frames)
    limit = 1 << (array.adc.bits - 1)
    bad = np.argwhere(np.abs(np.rint(stress / array.adc.lsb)) > limit)
    if len(bad):
        frame, row, column = bad[0]
        raise ValueError(
            f"frames: frame {frame}, row {row}, column {column} is {stress[tuple(bad[0])]:.6g} Pa, "
            f"over the full scale of {array.adc.full_scale:.6g} Pa"
        )
    return convert(array, stress)


def convert(array: Measured, frames: npt.ArrayLike) -> Ints:
    """The same for frames of any stress: values beyond full scale are clipped, as by a converter.

    :func:`saturated` tells which frames.  Raises ``ValueError`` naming the first taxel that is not finite.
    """
    limit = 1 << (array.adc.bits - 1)
    codes = np.rint(check_frames(array.sensor, frames) / array.adc.lsb)
    return np.clip(codes, -limit, limit - 1).astype(np.int64)


def saturated(array: Measured, codes: Ints) -> Bools:
    """Which frames of ``codes (n, ...)`` have a code at an end of its range, ``(n,)``."""
    top = (1 << (array.adc.bits - 1)) - 1
    return np.asarray(((codes >= top) | (codes <= -top - 1)).any(axis=tuple(range(1, codes.ndim))))
