"""Frames of a recording at the rate at which they were recorded, or another."""

import time
from collections.abc import Iterator

import numpy as np

from tfra.model.arrays import Floats
from tfra.recordings.frames import Recording

RATE = 100.0
"""Frames a second of a recording that does not know its own."""

SLOWEST, FASTEST = 1.0, 1e5
"""Frames a second: times that say something else are not in seconds."""


def due(recording: Recording, rate: float | None) -> Floats:
    """Return when each frame is due, ``(n,)`` in s since the first: ``rate`` a second, or as the recording says.

    Its times count if they rise and are in seconds: a log's are, those of other files where they give a likely rate.
    """
    times = recording.time
    if rate is None and times is not None and len(times) > 1 and (np.diff(times) > 0).all():
        own = float(1 / np.median(np.diff(times)))
        if recording.seconds or SLOWEST <= own <= FASTEST:
            return np.asarray(times - times[0])
    return np.arange(len(recording.frames)) / (rate or RATE)


def replayed(frames: Floats, when: Floats) -> Iterator[Floats]:
    """Yield each of ``frames (n, rows, columns)`` when it is due; the first is due at once."""
    begun = time.monotonic()
    for frame, at in zip(frames, when, strict=True):
        time.sleep(max(0.0, begun + at - time.monotonic()))
        yield frame
