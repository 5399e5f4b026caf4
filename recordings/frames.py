"""Reading recordings, and the ground truth of simulated frames, from files of any supported format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Archive, Array, Shape, archive, read_npy
from tfra.recordings.input import PLAIN, Input, arranged, codes_of, no_codes, overridden, stress
from tfra.recordings.log import is_bag, read_log
from tfra.recordings.parquet import read_parquet
from tfra.recordings.shapes import FRAMES, split, wrong_shape
from tfra.recordings.text import read_csv
from tfra.runtime.errors import InputError, shortened
from tfra.runtime.inputs import no_memory
from tfra.runtime.ownership import is_as_written

TIME = "time"
"""The key of the times."""

REFERENCES = {"resultant_ref": (3,), "mu_ref": (), "phi_ref_deg": ()}
"""True values of a frame, by key: their shapes; in N, 1 and degrees, nan where unknown."""

MOST = 1e12
"""Limit of any stress, force or angle in its SI unit or degrees: diamond breaks at 1e11 Pa.

The models square sums over taxels at most, so with 4096 taxels nothing overflows below 1e150.
"""

FORMATS = ".npz, .npy, .csv, .txt, .tsv, .parquet or .mcap"


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Frames ``(n, rows, columns)`` in Pa, compression negative, and their times ``(n,)``, if the file has them.

    ``seconds``: the times are in s since the first frame; otherwise their unit is unknown.  ``given``: how it was read.
    """

    frames: Floats
    time: Floats | None = None
    seconds: bool = False
    given: Input = PLAIN

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        low, high = self.frames.min(initial=0), self.frames.max(initial=0)
        times = "" if self.time is None else ", time"
        return f"<tfra.Recording of {len(self)} frames {self.frames.shape} in Pa, {low:.4g} to {high:.4g}{times}>"


def read_as(path: Path, chosen: Input, given: Mapping[str, Any]) -> Input:
    """How to read the recording at ``path``: as ``chosen`` in CONFIG's [input], but for the fields ``given``.

    What ``tfra frames`` wrote is in Pa and needs nothing of [input], which is about recordings.  Raises ``ValueError``
    as :func:`tfra.recordings.input.overridden`.
    """
    return overridden(PLAIN if is_as_written(path, "frames") else chosen, given)


def read_recording(path: str | Path, sensor: SensorArray, adc: Adc, given: Input) -> Recording:
    """Return the frames at ``path``, n >= 1, all finite and within ``MOST``, read as ``given`` says.

    docs/recordings.md has the formats.  Raises ``InputError`` naming the file and the line, frame, row or column that
    is wrong; rows, columns and frames count from 0, rows and columns where they are on the array.
    """
    file = Path(path)
    try:
        found = _levels(file, sensor, adc, given)
        rest = _rest(found.frames, file, sensor, adc, given)
        frames = pascals(file, found.frames, adc, given, rest)
    except MemoryError as error:
        raise no_memory(file, error) from None
    return replace(found, frames=frames)


def read_frames(path: str | Path, sensor: SensorArray) -> Floats:
    """Return the frames at ``path`` of a recording as ``tfra frames`` writes it: in Pa, compression negative."""
    return read_recording(path, sensor, Adc(), PLAIN).frames


def read_references(path: str | Path, count: int) -> dict[str, Floats]:
    """Return the ground truth in a .npz file of ``count`` frames: those of ``REFERENCES`` that it has.

    Unknown values are nan.  Raises ``InputError`` for a key of another shape, without real numbers, or with one that is
    infinite or beyond ``MOST``.  Other formats have no references.
    """
    file = Path(path)
    if file.suffix != ".npz":
        return {}
    with archive(file) as found:
        keys = [key for key in REFERENCES if key in found.keys]
        references = {key: _doubles(found.read(key, partial(_other_shape, (count, *REFERENCES[key])))) for key in keys}
    for key, values in references.items():
        if len(bad := np.argwhere(np.abs(values) > MOST)):
            raise InputError(file, key, f"frame {bad[0][0]}: {values[tuple(bad[0])]:g} is no true value")
    return references


def pascals(file: Path, levels: Floats, adc: Adc, given: Input, rest: Floats | None) -> Floats:
    """Return the stress of frames ``levels (n, rows, columns)`` in Pa; ``rest (k, rows, columns)`` is their tare.

    Raises ``InputError`` naming ``file`` for the first value that is no stress.
    """
    frames = stress(levels, given, adc, rest)
    _require_stress(file, frames)
    return frames


def tare_of(sensor: SensorArray, adc: Adc, given: Input) -> Floats | None:
    """Return the frames of the tare's own file, ``(k, rows, columns)`` in the recording's unit, if there is one."""
    return None if given.tare is None else _levels(given.tare, sensor, adc, given).frames


def in_place(file: Path, values: Floats, sensor: SensorArray, adc: Adc, given: Input) -> Floats:
    """Return ``values (n, rows * columns)`` in their own unit with every taxel in its place, ``(n, rows, columns)``.

    Raises ``InputError`` naming ``file`` for one that is not finite or, if they are codes, none of the converter's.
    """
    frames = arranged(values, given, sensor)
    if given != PLAIN:
        _require_finite(file, frames)
    if given.unit == "codes":
        _require_codes(file, frames, adc, given)
    return frames


def _levels(file: Path, sensor: SensorArray, adc: Adc, given: Input) -> Recording:
    """The recording in its own unit, every taxel in its place; all are numbers, or codes, if it has those."""
    values, time, seconds = _read(file, sensor, given)
    if not len(values):
        raise InputError(file, FRAMES, "at least one frame is needed, got none")
    return Recording(in_place(file, _doubles(values), sensor, adc, given), time, seconds, given)


def _rest(levels: Floats, file: Path, sensor: SensorArray, adc: Adc, given: Input) -> Floats | None:
    """The frames of the array at rest, in the recording's unit."""
    if given.tare is not None:
        return tare_of(sensor, adc, given)
    if given.tare_frames > len(levels):
        reason = f"the first {given.tare_frames} frames are the tare, the recording has {len(levels)} (--tare-frames)"
        raise InputError(file, FRAMES, reason)
    return levels[: given.tare_frames] if given.tare_frames else None


def _read(file: Path, sensor: SensorArray, given: Input) -> tuple[Array | Floats, Floats | None, bool]:
    """Values, a frame in each row or with its axes; times; and whether these are seconds."""
    check = partial(wrong_shape, sensor, given)
    match file.suffix.lower():
        case ".npz":
            with archive(file) as found:
                if FRAMES not in found.keys:
                    have = shortened(", ".join(found.keys), 120) or "none"
                    raise InputError(file, FRAMES, f"the key is missing, the file has: {have}")
                values, time = split(found.read(FRAMES, check), sensor, given)
                return values, _archived_time(found, len(values)) if time is None else time, False
        case ".npy":
            return *split(read_npy(file, FRAMES, check), sensor, given), False
        case ".csv" | ".txt" | ".tsv":
            return *read_csv(file, sensor, given.skip_columns), False
        case ".parquet":
            return *read_parquet(file, sensor, given), False
        case ".mcap":
            return *read_log(file, sensor, given), True
    if is_bag(file):
        return *read_log(file, sensor, given), True
    raise InputError(file, "", f"a name that ends in {FORMATS} is needed, or the folder of a rosbag2")


def _archived_time(found: Archive, count: int) -> Floats | None:
    """The numbers under ``TIME`` if there is one for each frame; other data of that name are ignored."""
    if TIME not in found.keys:
        return None
    try:
        times = _doubles(found.read(TIME, partial(_other_shape, (count,))))
    except InputError:
        return None
    return times if np.isfinite(times).all() else None


def _other_shape(needed: Shape, shape: Shape) -> str | None:
    return None if shape == needed else f"shape {needed} is needed, got {shortened(str(shape))}"


def _doubles(array: npt.NDArray[np.generic]) -> Floats:
    with np.errstate(all="ignore"):  # a long double may be infinite as a double
        return np.asarray(array, dtype=np.float64)


def _require_finite(file: Path, frames: Floats) -> None:
    if len(bad := np.argwhere(~np.isfinite(frames))):
        raise InputError(file, FRAMES, "frame {}, row {}, column {} is not finite".format(*bad[0]))


def _require_codes(file: Path, frames: Floats, adc: Adc, given: Input) -> None:
    if not len(bad := no_codes(frames, given, adc)):
        return
    value, (first, last) = frames[tuple(bad[0])], codes_of(given.coding, adc.bits)
    hint = ""
    if value % 1 or not -(2**adc.bits) <= value < 2**adc.bits:
        hint = ": is the unit Pa or kPa? (--unit)"
    elif given.coding == "signed" and frames.min() >= 0:
        hint = ": are they offset binary? (--coding offset)"
    elif frames.min() < 0:
        hint = ": are they signed? (--coding signed)"
    place = "frame {}, row {}, column {}".format(*bad[0])
    reason = f"{place} is {value:g}, {given.coding} codes of {adc.bits} bits are whole numbers from {first} to {last}"
    raise InputError(file, FRAMES, f"{reason}{hint}")


def _require_stress(file: Path, frames: Floats) -> None:
    """Raise ``InputError`` for the first value that cannot be a stress."""
    bad = np.argwhere(~(np.abs(frames) <= MOST))
    if not len(bad):
        return
    value = frames[tuple(bad[0])]
    reason = f"is {value:g} Pa, the limit is {MOST:g} Pa" if np.isfinite(value) else "is not finite"
    raise InputError(file, FRAMES, "frame {}, row {}, column {} {}".format(*bad[0], reason))
