"""Reads the result of ``tfra estimate`` for a skin."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.skin.finding import Mark
from tfra.model.skin.result import SkinResult
from tfra.model.skin.skin import Skin
from tfra.model.tfra import Status
from tfra.recordings.arrays import Archive, archive
from tfra.runtime.errors import InputError
from tfra.view.resultfile import frames_of, numbers, source, whole, windows

COUNTS = ("found", "dropped")
"""Keys of a skin's result with a number for each frame."""

PLACES = ("frame", "contact", "x_mm", "y_mm", "taxels", "top", "left")
"""Keys with a number for each contact."""

_BITS = sum(Status) + sum(Mark)


@dataclass(frozen=True)
class RecordedSkin:
    """A result of a skin as ``tfra estimate`` wrote it.

    ``stress (n, rows, columns)`` is what its engine saw, in Pa, compression negative; ``time (n,)`` in seconds, where
    the recording has it; ``dead (rows, columns)``: taxels that neighbours stood in for; None: none.
    """

    name: str
    engine: str
    skin: Skin
    found: SkinResult
    stress: Floats
    time: Floats | None
    dead: Bools | None = None


def is_of_skin(path: Path) -> bool:
    """Whether the archive at ``path`` is the result of a skin; raises ``InputError`` for what is no archive."""
    with archive(path) as found:
        return set(COUNTS) <= set(found.keys)


def read_skin(path: Path) -> RecordedSkin:
    """Return the result at ``path``; raises ``InputError`` for one that is damaged or contradicts itself."""
    with archive(path) as found:
        engine, project = source(found)
        skin = project.skin
        if skin is None:
            raise InputError(path, "config", "has no section window, which the CONFIG of a skin's result has")
        stress, time, dead = frames_of(found, skin.sensor)
        return RecordedSkin(path.name, engine, skin, _contacts(found, skin, len(stress)), stress, time, dead)


def _contacts(found: Archive, skin: Skin, count: int) -> SkinResult:
    counts = {key: whole(found, key, numbers(found, key, (count,))) for key in COUNTS}
    if (counts["found"] < 0).any():
        raise InputError(found.file, "found", "counts of contacts are needed, got a negative number")
    each = int(counts["found"].sum())
    places = {key: numbers(found, key, (each,)) for key in PLACES}
    x, y = (1e-3 * places.pop(key) for key in ("x_mm", "y_mm"))
    integers = {key: whole(found, key, values) for key, values in places.items()}
    if (integers["frame"] != np.repeat(np.arange(count), counts["found"])).any():
        raise InputError(found.file, "frame", "is not what the numbers of found say")
    pitch = min(skin.sensor.pitch_x, skin.sensor.pitch_y)
    return SkinResult(x=x, y=y, windows=windows(found, each, skin.window, _BITS), pitch=pitch, **integers, **counts)
