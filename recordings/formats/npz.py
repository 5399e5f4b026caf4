"""Recordings in NumPy's files: the array of a .npy file, or ``frames`` and perhaps ``time`` of a .npz file."""

from functools import partial
from pathlib import Path

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Archive, archive, fits, read_npy
from tfra.recordings.formats import FRAMES, Format, Values, finite, split, wrong_shape
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError, shortened

TIME = "time"
"""The key of the times."""


def read(file: Path, sensor: SensorArray, given: Input) -> Values:
    """Return the frames of ``file``; raises ``InputError``.

    The times are those of the first skipped column, else those of a .npz file if there is one for each frame.
    """
    check = partial(wrong_shape, sensor, given)
    if file.suffix.lower() == ".npy":
        return Values(*split(read_npy(file, FRAMES, check), sensor, given))
    with archive(file) as stored:
        if FRAMES not in stored.keys:
            have = shortened(", ".join(stored.keys), 120) or "none"
            raise InputError(file, FRAMES, f"the key is missing, the file has: {have}")
        frames, time = split(stored.read(FRAMES, check), sensor, given)
        return Values(frames, _time(stored, len(frames)) if time is None else time)


def _time(stored: Archive, count: int) -> Floats | None:
    """The ``count`` numbers under ``TIME``; other data of that name are ignored."""
    if TIME not in stored.keys:
        return None
    try:
        return finite(stored.read(TIME, fits((count,))))
    except InputError:
        return None


FORMAT = Format((".npz", ".npy"), read)
