"""When the frames of a recording are due."""

import time

import numpy as np
import pytest

from tfra.recordings.frames import Recording
from tfra.recordings.replay import due, replayed

FRAMES = np.arange(24.0).reshape(4, 2, 3)


@pytest.mark.parametrize(
    ("times", "seconds", "rate", "expected"),
    [
        (None, False, None, [0, 0.01, 0.02, 0.03]),
        (None, False, 50.0, [0, 0.02, 0.04, 0.06]),
        ([7, 7.5, 7.6, 8], False, None, [0, 0.5, 0.6, 1]),  # seconds
        ([7, 7.5, 7.6, 8], False, 4.0, [0, 0.25, 0.5, 0.75]),
        ([0, 20, 40, 60], False, None, [0, 0.01, 0.02, 0.03]),  # milliseconds, perhaps
        ([0, 20, 40, 60], True, None, [0, 20, 40, 60]),
        ([0, 0.5, 0.5, 1], True, None, [0, 0.01, 0.02, 0.03]),  # no order to follow
    ],
)
def test_due(times: list[float] | None, seconds: bool, rate: float | None, expected: list[float]) -> None:
    recording = Recording(FRAMES, None if times is None else np.array(times, dtype=np.float64), seconds)
    np.testing.assert_allclose(due(recording, rate), expected, atol=1e-12)


def test_no_frame_comes_before_it_is_due() -> None:
    begun, when = time.monotonic(), np.array([0, 0.02, 0.02, 0.05])
    for frame, expected, at in zip(replayed(FRAMES, when), FRAMES, when, strict=True):
        np.testing.assert_array_equal(frame, expected)
        assert time.monotonic() >= begun + at
