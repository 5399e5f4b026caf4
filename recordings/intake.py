"""Frames in a recording's unit, as they come, to stress: means of them, the tare, then the front end."""

import numpy as np

from tfra.model.arrays import Bools, Floats
from tfra.model.choices import Adc
from tfra.recordings.front_end import FrontEnd
from tfra.recordings.input import Input
from tfra.recordings.levels import tare_doubts

TARE_FRAMES = 50
"""Frames of a new tare, if the recording has none of its own."""


def averaged(levels: Floats, count: int) -> Floats:
    """Means ``(n // count, rows, columns)`` of ``count`` frames each; what is left over is in none."""
    whole = len(levels) // count
    if count == 1:
        return levels
    return np.asarray(levels[: whole * count].reshape(whole, count, *levels.shape[1:]).mean(axis=1))


class Intake:
    """Called with frames ``(n, rows, columns)``, in order; returns the stress of those that are complete, in Pa.

    ``given.average`` of them are one frame, and the first ``given.tare_frames`` of these are the tare, which is not
    returned.  A new tare is the next so many frames, or ``TARE_FRAMES``.
    """

    def __init__(self, convert: FrontEnd, adc: Adc, given: Input) -> None:
        self._convert, self._adc, self._given = convert, adc, given
        self._wanted = given.tare_frames
        self._again = False
        self._left: list[Floats] = []
        self._tare: list[Floats] = []
        self.told = self._waits() if self._wanted else ""
        """What became of the tare, for a reader."""

    def __call__(self, levels: Floats) -> Floats:
        """The stress of 0 to n frames."""
        self._left.append(levels)
        there = sum(map(len, self._left))
        if there < self._given.average:
            return levels[:0]
        frames = np.concatenate(self._left)
        self._left = [frames[there - there % self._given.average :]]
        shown = self._after_tare(averaged(frames, self._given.average))
        return self._convert(shown) if len(shown) else shown

    @property
    def alive(self) -> Bools:
        """Taxels whose numbers count, ``(rows, columns)``."""
        return self._convert.alive

    def again(self) -> None:
        """Take the next frames for a new tare, whatever thread asks."""
        self._again = True
        self.told = "Tare: keep the array at rest."

    def _after_tare(self, levels: Floats) -> Floats:
        """The frames that are not of the tare."""
        if self._again:
            self._again, self._tare, self._wanted = False, [], self._given.tare_frames or TARE_FRAMES
        missing = self._wanted - len(self._tare)
        if not missing:
            return levels
        self._tare.extend(levels[:missing])
        self.told = self._waits()
        if len(self._tare) == self._wanted:
            rest = np.array(self._tare)
            self._convert.tare(rest)
            said = list(tare_doubts(rest, self._convert.alive, self._adc, self._given))
            self.told = f"Tare: the mean of {self._wanted} frames" + "".join(f"; {each}" for each in said) + "."
        return levels[missing:]

    def _waits(self) -> str:
        return f"Tare: keep the array at rest, {len(self._tare)} of {self._wanted} frames have come."
