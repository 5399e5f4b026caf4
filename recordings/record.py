"""Results of frames as they come, kept for a file at the end."""

import warnings
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import numpy as np

from tfra.model.arrays import Floats
from tfra.recordings.frames import Recording
from tfra.runtime.errors import Notice

MOST_BYTES = 1 << 29
"""Of the stress that is kept; the forces of the taxels take three times as much."""

Found = TypeVar("Found")


class Record(Generic[Found]):
    """An engine as a function of stress ``(n, rows, columns)``, whose results are kept with their frames and times.

    ``join`` makes one result of several.
    """

    def __init__(self, estimate: Callable[[Floats], Found], join: Callable[[Sequence[Found]], Found]) -> None:
        self._estimate, self._join = estimate, join
        self._times: list[Floats] = []
        self._stress: list[Floats] = []
        self._results: list[Found] = []
        self._last: tuple[Floats, Found]
        self._room = MOST_BYTES

    def __call__(self, stress: Floats) -> Found:
        """The result of the engine."""
        found = self._estimate(stress)
        self._last = stress, found
        return found

    def keep(self, times: Floats) -> None:
        """Keep the last result, of frames that came at ``times (n,)`` in s, if there is room."""
        stress, found = self._last
        if self._room <= 0:
            return
        self._room -= stress.nbytes
        self._times.append(times)
        self._stress.append(stress)
        self._results.append(self._join([found]))  # without what is not for files
        if self._room <= 0:
            frames = f"{sum(map(len, self._times)):,} frames"
            warnings.warn(f"--out: {frames} are all that there is room for: later ones are shown alone", Notice, 2)

    def kept(self) -> tuple[Recording, Found] | None:
        """The frames that were kept, and their result; None without any."""
        if not self._results:
            return None
        recording = Recording(np.concatenate(self._stress), np.concatenate(self._times), seconds=True)
        return recording, self._join(self._results)
