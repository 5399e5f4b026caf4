"""Where a recording shows a load, and what is read from it."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from tfra.calibrate.loads import Load
from tfra.calibrate.presses import read_press, read_rest, rearranged
from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.input import Input, arranged
from tfra.runtime.errors import InputError

FILE, PRESS = Path("press.npy"), Load("press", 2, normal=5.0)
SHAPE = np.exp(-((np.arange(4)[:, None] - 1.5) ** 2) - (np.arange(5) - 2.0) ** 2)


def recording(profile: Floats, peak: float = 200.0, noise: float = 1.0, drift: float = 0.0, seed: int = 1) -> Floats:
    """Levels at 100 plus a press with the ``profile`` of frames."""
    rng = np.random.default_rng(seed)
    along = drift * np.arange(len(profile))[:, None, None]
    return 100 + along + peak * profile[:, None, None] * SHAPE + noise * rng.standard_normal((len(profile), 4, 5))


def profile(rest: int = 30, held: int = 40, after: int = 25) -> Floats:
    ramp = np.linspace(0, 1, 7)[1:-1]
    return np.concatenate([np.zeros(rest), ramp, np.ones(held), ramp[::-1], np.zeros(after)])


@pytest.mark.parametrize("peak", [12.0, 60.0, 200.0, -200.0])
def test_a_press_is_found(peak: float) -> None:
    found = read_press(FILE, PRESS, recording(profile(), peak))
    first, last = found.span
    assert 34 <= first <= 45
    assert 60 <= last <= 75
    error = np.sqrt(found.variance(np.ones((4, 5))))
    assert (np.abs(found.deviation - peak * SHAPE) < 5 * error).all()
    assert found.noise == pytest.approx(np.ones((4, 5)), abs=0.5)


def test_an_offset_that_drifts_is_followed_from_rest_to_rest() -> None:
    found = read_press(FILE, PRESS, recording(profile(), drift=0.05))
    assert np.abs(found.deviation - 200 * SHAPE).max() < 1.5
    assert found.moved == pytest.approx(np.full((4, 5), 0.05 * 75), abs=1.0)


def test_the_longest_of_two_presses_counts_and_frames_choose_another() -> None:
    levels = recording(np.concatenate([profile(20, 15, 20), profile(0, 60, 20)]))
    assert read_press(FILE, PRESS, levels).frames > 50
    chosen = read_press(FILE, Load("press", 2, normal=5.0, frames=(26, 38)), levels)
    assert chosen.span == (26, 38)
    assert np.abs(chosen.deviation - 200 * SHAPE).max() < 2


@pytest.mark.parametrize(
    ("levels", "reason"),
    [
        (recording(np.zeros(100)), "shows no load"),
        (np.full((50, 4, 5), 7.0), "shows no load"),
        (recording(np.concatenate([np.linspace(0, 1, 5), np.ones(95)])), "start at rest"),
    ],
)
def test_recordings_without_a_load(levels: Floats, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        read_press(FILE, PRESS, levels)


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_is_no_load(seed: int) -> None:
    rng = np.random.default_rng(seed)
    with pytest.raises(InputError, match="shows no load"):
        read_press(FILE, PRESS, rng.standard_normal((int(rng.integers(40, 300)), 30, 30)))


def test_frames_beyond_the_recording() -> None:
    with pytest.raises(InputError, match=r"frames: 90-120 of the table is not after rest within 105 frames"):
        read_press(FILE, Load("press", 2, normal=5.0, frames=(90, 120)), recording(profile()))


def test_rest_tells_noise_and_drift() -> None:
    found = read_rest(FILE, Load("rest", 2), recording(np.zeros(300), drift=0.02))
    assert found.noise == pytest.approx(np.ones((4, 5)), abs=0.3)
    assert found.moved == pytest.approx(np.full((4, 5), 4.0), abs=0.6)
    assert not found.deviation.any()


def test_taxels_move_between_the_ways_of_a_recording() -> None:
    sensor = SensorArray(4, 5, 1.0, 1.0, 1.0)
    flat = np.random.default_rng(3).standard_normal((1, 20))
    ways = [
        Input(order=o, flip_x=x, flip_y=y) for o in ("rows", "columns") for x in (False, True) for y in (False, True)
    ]
    for before in ways:
        for after in ways:
            moved = rearranged(arranged(flat, before, sensor)[0], before, after, sensor)
            assert (moved == arranged(flat, after, sensor)[0]).all()


@given(
    levels=arrays(np.float64, array_shapes(min_dims=3, max_dims=3, max_side=12), elements=st.floats(-4096, 4096)),
    frames=st.none() | st.tuples(st.integers(0, 12), st.integers(0, 12)).map(lambda pair: (min(pair), max(pair))),
)
def test_any_recording_is_read_or_refused_in_a_line(levels: Floats, frames: tuple[int, int] | None) -> None:
    try:
        found = read_press(FILE, Load("press", 2, normal=5.0, frames=frames), levels)
    except InputError:
        return
    assert np.isfinite(found.deviation).all()
    assert 0 < found.span[0] <= found.span[1] < len(levels)
