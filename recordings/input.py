"""From the numbers of a recording to stress in Pa, by their unit, sign and order."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tfra.model.arrays import Floats
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
    without stress to 2^bits - 1.  ``pa_per_code``: stress of one; None: that of the converter.  ``tare_frames``, the
    first of the recording, the file ``tare``, or the code ``rest_code`` of all taxels show the array at rest; 0 and
    None: none of them.  ``drift_frames``: between contacts the offset follows the numbers with this time constant; 0:
    it stays.  ``average`` frames of the file are one, their mean, and all other numbers of frames are of means.
    ``dead``: rows and columns of taxels on the array that are computed from their neighbours.
    ``calibration``: a file with the gains, the numbers at rest and the dead ones of the taxels.
    ``order``: whether a frame runs along rows, (rows, columns), or along columns, (columns, rows).  ``flip_x`` and
    ``flip_y`` mirror the array along x and y.  The first ``skip_columns`` of a line are no taxels; or ``columns`` are:
    a range of them, from 1, or a pattern of their names.  ``strict``: no line of text may be wrong.  ``topic`` is that
    of the messages in a log; None: the only one that fits.
    """

    unit: Unit = "Pa"
    compression: Sign = "negative"
    coding: Coding = "signed"
    pa_per_code: float | None = None
    rest_code: float | None = None
    tare_frames: int = 0
    tare: Path | None = None
    drift_frames: int = 0
    average: int = 1
    dead: tuple[tuple[int, int], ...] = ()
    calibration: Path | None = None
    order: Order = "rows"
    flip_x: bool = False
    flip_y: bool = False
    skip_columns: int = 0
    columns: str | None = None
    strict: bool = False
    topic: str | None = None

    def shape(self, sensor: SensorArray) -> tuple[int, int]:
        """The axes of a frame in the recording."""
        return (sensor.rows, sensor.columns) if self.order == "rows" else (sensor.columns, sensor.rows)

    def level_at_rest(self, bits: int) -> float:
        """The number of a taxel at rest, without a tare; codes have ``bits``."""
        if self.rest_code is not None:
            return self.rest_code
        return float(1 << (bits - 1)) if self.unit == "codes" and self.coding == "offset" else 0.0


PLAIN = Input()
"""The format of ``tfra frames``: pascals, compression negative, row by row."""


FILES = ("tare", "calibration")
"""Fields that name files."""

_REST: dict[str, Any] = {"tare": None, "tare_frames": 0, "rest_code": None}
"""Fields that say what the array reads at rest, without any of them."""

_OF_CODES = {"coding": "a coding", "pa_per_code": "a stress of one", "rest_code": "a code at rest"}


def overridden(chosen: Input, given: Mapping[str, Any]) -> Input:
    """Return ``chosen`` with the fields ``given`` in place of its own; what is said of the array at rest replaces that.

    Raises ``ValueError`` that starts with ``key:`` for fields that contradict each other.
    """
    rest = [key for key in _REST if given.get(key) not in (None, 0) or (key == "rest_code" and key in given)]
    if len(rest) > 1:
        raise ValueError(f"{rest[0]}: give the array at rest once: as a file, as first frames or as a code")
    if rest or "tare_frames" in given:
        chosen = replace(chosen, **_REST)
    if "dead" in given:
        given = {**given, "dead": tuple((row, column) for row, column in given["dead"])}
    found = replace(chosen, **given)
    if found.columns and found.skip_columns:
        raise ValueError("columns: and skip_columns exclude each other")
    _check_average(found.average)
    for key, what in _OF_CODES.items():
        if key in given and found.unit != "codes":
            raise ValueError(f"{key}: only codes have {what}: the unit must be codes, not {found.unit}")
    return found


def _check_average(count: int) -> None:
    """Raise ``ValueError`` for a ``count`` of frames that the core makes no mean of."""
    from tfra.model.fixed.front_end import MOST_AVERAGED  # here, since it takes long: every command reads this file

    counts = [1 << log2 for log2 in range(MOST_AVERAGED + 1)]
    if count not in counts:
        raise ValueError(f"average: one of {', '.join(map(str, counts))} is needed, got {count}")


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
