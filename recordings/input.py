"""From the numbers of a recording to stress in Pa, by their unit, sign and order."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray

Unit = Literal["Pa", "kPa", "codes"]
Sign = Literal["negative", "positive"]
Coding = Literal["signed", "offset", "unipolar"]
Order = Literal["rows", "columns"]

PASCALS: dict[Unit, float] = {"Pa": 1.0, "kPa": 1000.0}
"""Pa per unit; for codes the converter determines it."""


@dataclass(frozen=True, slots=True)
class Input:
    """Format of the numbers of a recording; the default is that of ``tfra frames``.

    ``coding`` is of codes: two's complement; offset binary, at rest at half of its 2^bits codes; or unipolar, from 0
    without stress to 2^bits - 1.  ``tare_frames``, the first of the recording, or the file ``tare`` show the array at
    rest; 0 and None: no tare.  ``order``: whether a frame runs along rows, (rows, columns), or along columns, (columns,
    rows).  ``flip_x`` and ``flip_y`` mirror the array along x and y.  The first ``skip_columns`` of a line are no
    taxels.  ``topic`` is that of the messages in a log; None: the only one that fits.
    """

    unit: Unit = "Pa"
    compression: Sign = "negative"
    coding: Coding = "signed"
    tare_frames: int = 0
    tare: Path | None = None
    order: Order = "rows"
    flip_x: bool = False
    flip_y: bool = False
    skip_columns: int = 0
    topic: str | None = None

    def shape(self, sensor: SensorArray) -> tuple[int, int]:
        """The axes of a frame in the recording."""
        return (sensor.rows, sensor.columns) if self.order == "rows" else (sensor.columns, sensor.rows)


PLAIN = Input()
"""The format of ``tfra frames``: pascals, compression negative, row by row."""


def overridden(chosen: Input, given: Mapping[str, Any]) -> Input:
    """Return ``chosen`` with the fields ``given`` in place of its own; a tare of either kind replaces the other kind.

    Raises ``ValueError`` that starts with ``key:`` for fields that contradict each other.
    """
    if given.get("tare_frames") and "tare" in given:
        raise ValueError("tare: give the tare as a file or as first frames, not as both")
    if "tare" in given:
        chosen = replace(chosen, tare_frames=0)
    elif "tare_frames" in given:
        chosen = replace(chosen, tare=None)
    found = replace(chosen, **given)
    if "coding" in given and found.unit != "codes":
        raise ValueError(f"coding: only codes have a coding: the unit must be codes, not {found.unit}")
    return found


def arranged(values: Floats, given: Input, sensor: SensorArray) -> Floats:
    """Return ``values (n, rows * columns)`` or ``(n, *given.shape(sensor))`` as frames ``(n, rows, columns)``."""
    frames = values.reshape(len(values), *given.shape(sensor))
    if given.order == "columns":
        frames = frames.transpose(0, 2, 1)
    if given.flip_x:
        frames = frames[:, :, ::-1]
    if given.flip_y:
        frames = frames[:, ::-1]
    changed = given.order == "columns" or given.flip_x or given.flip_y
    return np.ascontiguousarray(frames) if changed else frames


def codes_of(coding: Coding, bits: int) -> tuple[int, int]:
    """The first and the last code of a converter."""
    half = 1 << (bits - 1)
    return (-half, half - 1) if coding == "signed" else (0, 2 * half - 1)


def stress(frames: Floats, given: Input, adc: Adc, rest: Floats | None = None) -> Floats:
    """Return the stress of ``frames (n, rows, columns)`` in the recording's unit: Pa, compression negative.

    ``rest (k, rows, columns)``, in the same unit, shows the array at rest: its mean is subtracted.

    The mean of codes is the nearest double, that of other numbers is a sum of doubles over their count; the subtraction
    rounds once.  The unit's factor is exact, and its product the nearest double: exact for codes wherever a code in Pa,
    which is full scale over a power of two, has 33 significant bits at most, as all whole numbers below 8.5 GPa.
    Nothing is rounded if there is neither a tare nor a factor.
    """
    level = frames
    if given.unit == "codes" and given.coding == "offset" and rest is None:
        level = level - float(1 << (adc.bits - 1))
    if rest is not None:
        level = level - rest.mean(axis=0)
    code = adc.lsb / 2 if given.coding == "unipolar" else adc.lsb  # all bits of unipolar codes are for one sign
    if (factor := PASCALS.get(given.unit, code)) != 1:
        level = level * factor
    return -level if given.compression == "positive" else level
