"""Frames one at a time, or a few, as they come: from the converter's numbers to forces."""

from collections.abc import Callable
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

from tfra.array import keywords
from tfra.codegen.config.read import Project
from tfra.recordings.frames import Recording, front_end, in_place, pascals, tare_of
from tfra.recordings.intake import Intake
from tfra.runtime.errors import InputError

Found = TypeVar("Found")


class Stream(Generic[Found]):
    """Called with numbers of the sensor, returns the result of the frames that they complete; ``stream`` makes one.

    Its state are the frames of a mean that has begun, the tare, and the offset that is followed.
    """

    def __init__(self, call: str, project: Project, estimate: Callable[[Recording], Found]) -> None:
        self._call, self._project, self._estimate = call, project, estimate
        sensor, adc, given = self._known = project.array.sensor, project.array.adc, project.input
        convert = front_end(Path(call), sensor, adc, given, tare_of(sensor, adc, given))
        self._intake = Intake(convert, adc, given)

    def __repr__(self) -> str:
        return f"<tfra stream of {self._project.design.name}{f', {self.told}' if self.told else ''}>"

    @property
    def told(self) -> str:
        """What became of the tare, in a sentence: how many frames are missing, or what looks wrong with it."""
        return self._intake.told

    def tare(self) -> None:
        """Take the next ``tare_frames`` frames, or 50, for a new tare."""
        self._intake.again()

    def __call__(self, frames: npt.ArrayLike) -> Found | None:
        """The result of ``frames``, ``(rows, columns)`` or ``(n, rows, columns)``; None while none is complete.

        They are in the unit, and in the order of rows and columns, that ``stream`` was told.

        Raises ``tfra.InputError`` for another shape, for what is no number, for codes that the converter does not have,
        and for stress over full scale where the engine sees codes; such frames are left out.
        """
        sensor, adc, given = self._known
        values, shape = np.asarray(frames), given.shape(sensor)
        if values.dtype.kind not in "iuf":
            raise InputError(self._call, "frames", "real numbers in one array are needed")
        if values.shape[-2:] != shape or values.ndim not in (2, 3):
            needed = f"({shape[0]}, {shape[1]}) or (n, {shape[0]}, {shape[1]})"
            raise InputError(self._call, "frames", f"shape {needed} is needed, got {values.shape}")
        call = Path(self._call)
        with keywords():
            levels = in_place(call, values.reshape(-1, *shape).astype(np.float64), sensor, adc, given)
            stress = pascals(call, levels, self._intake)
            return self._estimate(Recording(stress, given=given)) if len(stress) else None
