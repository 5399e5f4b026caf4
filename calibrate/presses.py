"""Recordings of loads become readings: what every taxel shows at rest and under the load."""

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d

from tfra.calibrate.loads import Load
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.sensor import SensorArray
from tfra.recordings.input import Input, arranged
from tfra.runtime.errors import InputError

AT_START = 20
"""Most frames at the start of a recording that are taken for rest before it is known where the load begins."""

LEAST_AT_REST = 2
"""Frames at rest before a load."""

STEADY = 0.03
"""How far a frame under the load may be from the usual one, relative; noise may be more."""

BLURRED = 0.05
"""Noise of a frame over the load, above which frames are averaged to find when it begins and ends."""

MOST_AVERAGED = 0.2
"""Share of a recording that may be averaged so."""

NEARLY = 0.1
"""Of a load: frames that show less are taken for rest, unless there is noise."""

RETURNED = 0.2
"""A share of the load below which the end of a recording is at rest: the offset may have moved so far."""

UNSEEN = 2.0
"""A mean of frames under a load differs from rest by more than this times what noise would do, in squares."""


class UnseenError(InputError):
    """A recording in which no load is seen."""


@dataclass(frozen=True, eq=False)
class Reading:
    """What the recording ``file`` of a ``load`` shows, in its own unit; all arrays are ``(rows, columns)``.

    ``rest``: at rest, at the time of the load; ``pressed``: the mean under the load, from frame ``span[0]`` to
    ``span[1]``, the same as ``rest`` if there is none; ``noise``: standard deviation of a frame at rest; ``moved``: the
    offset's way over the recording; ``changes``: taxels that ever do.
    """

    file: Path
    load: Load
    rest: Floats
    pressed: Floats
    noise: Floats
    moved: Floats
    changes: Bools
    span: tuple[int, int]
    frames_at_rest: int

    def placed(self, before: Input, after: Input, sensor: SensorArray) -> "Reading":
        """The same with the taxels, which are placed as ``before`` says, placed as ``after``."""

        def moved(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
            return rearranged(values, before, after, sensor)

        values = {each.name: getattr(self, each.name) for each in fields(self)}
        changed: dict[str, Any] = {name: moved(v) if isinstance(v, np.ndarray) else v for name, v in values.items()}
        return Reading(**changed)

    @property
    def frames(self) -> int:
        """Frames under the load."""
        return self.span[1] - self.span[0] + 1

    @property
    def deviation(self) -> Floats:
        """Of the load from rest, in the recording's unit."""
        return np.asarray(self.pressed - self.rest)

    def variance(self, noise: Floats) -> Floats:
        """Of the deviation, from the ``noise`` of a frame."""
        return np.asarray(noise**2 * (1 / self.frames + 1 / self.frames_at_rest))


def rearranged(values: npt.NDArray[Any], before: Input, after: Input, sensor: SensorArray) -> npt.NDArray[Any]:
    """Numbers of taxels ``(rows, columns)``, in their places by ``before``, in those by ``after``."""
    every = np.arange(sensor.taxels, dtype=np.float64)[None]
    source, target = (arranged(every, given, sensor)[0].astype(np.int64) for given in (before, after))
    flat = np.empty_like(values.ravel())
    flat[source] = values
    return np.asarray(flat[target])


def read_rest(file: Path, load: Load, levels: Floats) -> Reading:
    """The reading of an array at rest from ``levels (n, rows, columns)``."""
    mean = levels.mean(axis=0)
    third = max(1, len(levels) // 3)
    moved = levels[-third:].mean(axis=0) - levels[:third].mean(axis=0)
    span = 0, len(levels) - 1
    return Reading(file, load, mean, mean, _noise(levels), moved, np.ptp(levels, axis=0) > 0, span, len(levels))


def read_press(file: Path, load: Load, levels: Floats) -> Reading:
    """The reading of a load from ``levels (n, rows, columns)`` that start at rest, and may end so.

    The load is the longest time that frames look alike.  Raises ``UnseenError`` for a recording that shows none, and
    ``InputError`` for one that does not start at rest, or is not held.
    """
    before, (first, last), after = _parts(file, load, levels)
    start, end = levels[before], levels[after]
    rest, moved = start.mean(axis=0), np.zeros(levels.shape[1:])
    if len(end) >= min(AT_START, len(start)):
        moved = end.mean(axis=0) - rest
        times = before.mean(), (first + last) / 2, after.mean()
        rest = rest + moved * (times[1] - times[0]) / (times[2] - times[0])
    pressed = levels[first : last + 1].mean(axis=0)
    changes = np.ptp(levels, axis=0) > 0
    return Reading(file, load, rest, pressed, _noise(start), moved, changes, (first, last), len(start) + len(end))


def _parts(file: Path, load: Load, levels: Floats) -> tuple[Ints, tuple[int, int], Ints]:
    """The frames at rest before the load, the first and the last under it, and those at rest after it."""
    start = max(1, min(AT_START, len(levels) // 10))
    if load.frames and not start < load.frames[0] <= load.frames[1] < len(levels):
        reason = f"{load.frames[0]}-{load.frames[1]} of the table is not after rest within {len(levels)} frames"
        raise InputError(file, "frames", reason)
    share, blur = _shares(file, load, levels, start)
    width = math.ceil(max(1.0, (blur / BLURRED) ** 2))
    if width > len(levels) * MOST_AVERAGED:
        reason = "shows no load that stands out of its noise: does it start at rest, and is the force large enough?"
        raise UnseenError(file, "", reason)
    share = uniform_filter1d(share, width)
    tolerance = max(STEADY, 4 * blur / math.sqrt(width))
    usual, end = float(np.median(share[share > share.max() / 2])), float(np.median(share[-start:]))
    steady = np.abs(share - usual) < tolerance
    if not (load.frames or steady.any()):
        raise InputError(file, "", "no frames look alike under the load: hold it for longer")
    first, last = load.frames or _longest(steady)
    resting, ended = np.abs(share) < tolerance, np.abs(share - end * (abs(end) < RETURNED)) < tolerance
    near = 1 + width // 2  # within so many frames the load may be on its way
    before, after = np.flatnonzero(resting[:first]), last + 1 + np.flatnonzero(ended[last + 1 :])
    before, after = before[before < before.max(initial=0) + 1 - near], after[after >= after.min(initial=0) + near]
    if len(before) < LEAST_AT_REST:
        raise InputError(file, "", "does not start at rest: record some frames before the load")
    trim = near if not load.frames and last - first > 2 * near + 2 else 0
    return before, (first + trim, last - trim), after


def _shares(file: Path, load: Load, levels: Floats, start: int) -> tuple[Floats, float]:
    """The share of the load that each frame shows, ``(n,)``, and the noise of a share.

    Rest is first taken from the frames at the ``start``, and the load from the strongest ones; then both from all
    frames that are more like the one or the other, since the noise of few frames would look like a share.
    """
    flat = levels.reshape(len(levels), -1)
    noise = np.nan_to_num(_noise(levels[:start])).ravel()
    rest = np.arange(len(flat)) < start
    order = np.argsort(((flat - flat[rest].mean(axis=0)) ** 2).sum(axis=1))
    under = np.isin(np.arange(len(flat)), order[-max(3, len(flat) // 10) :])
    if load.frames:
        under = (np.arange(len(flat)) >= load.frames[0]) & (np.arange(len(flat)) <= load.frames[1])
    for last in (False, True):
        base = flat[rest].mean(axis=0)
        loaded = flat[under].mean(axis=0) - base
        energy = loaded @ loaded
        if energy <= UNSEEN * (noise @ noise) * (1 / under.sum() + 1 / rest.sum()):
            raise UnseenError(file, "", "shows no load: is it the right recording, and does it start at rest?")
        share, blur = (flat - base) @ loaded / energy, float(np.linalg.norm(noise * loaded) / energy)
        near = min(0.5, max(NEARLY, 2 * blur))
        if not last:
            rest, under = share < near, (under if load.frames else share > 1 - near)
            if not (rest.any() and under.any()):
                raise InputError(file, "", "does not start at rest: record some frames before the load")
    return share, blur


def _longest(which: Bools) -> tuple[int, int]:
    """The first and the last place of the longest run of ``which``."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest]) - 1


def _noise(levels: Floats) -> Floats:
    """Standard deviation of frames from the one before, so that drift counts little; nan of fewer than three."""
    if len(levels) < 3:
        return np.full(levels.shape[1:], np.nan)
    return np.asarray(np.diff(levels, axis=0).std(axis=0) / np.sqrt(2))
