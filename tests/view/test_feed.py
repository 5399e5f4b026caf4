"""The feed: what came, what was estimated, what is kept, and what is said."""

import json
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import tfra.view.feed as module
from tests.view.made import unpacked
from tfra.model.arrays import Floats
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Tfra
from tfra.view.feed import Feed
from tfra.view.page import live_feed

DESIGN = TfraDesign(SensorArray(4, 6, 4e-3, 3e-3, 3e-3))

FRAMES = np.random.default_rng(5).normal(-1e4, 1e4, (200, 4, 6))


def feed(*frames: Any, estimate: Any = None) -> tuple[Feed, list[str]]:
    """A feed that has read ``frames`` before it estimates the first, and what was told."""
    made, told = live_feed("here", "float", DESIGN, estimate or Tfra.of(DESIGN)), []
    for each in frames:
        made.read(each, told.append)
    threading.Thread(target=made.run, daemon=True).start()
    return made, told


def answer(made: Feed, after: int = -1, patience: float = 10.0) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(made.since(after, patience)[0])
    return found


def test_a_piece_holds_the_numbers_of_its_frames() -> None:
    made, told = feed(FRAMES[:3])
    found = answer(made)
    (piece,) = found["pieces"]
    expected = Tfra.of(DESIGN)(FRAMES[:3])
    (result,) = piece["results"]
    np.testing.assert_allclose(unpacked(result["values"]["mu"]), expected.mu, rtol=1e-6)
    np.testing.assert_allclose(unpacked(result["values"]["phi"]), expected.phi_deg, rtol=1e-6)
    codes, scale = (unpacked(result["stress"][key]) for key in ("codes", "scale"))
    np.testing.assert_allclose(codes.reshape(3, 24) * scale[:, None], FRAMES[:3].reshape(3, 24), atol=2)
    np.testing.assert_array_equal(unpacked(piece["numbers"]), [0, 1, 2])
    assert unpacked(piece["time"])[0] == 0
    assert found["message"] == "here has ended."
    assert told == []


def test_frames_that_nobody_has_time_for_are_left_out() -> None:
    """All came before the first was estimated: the latest 64 are."""
    made, _ = feed(FRAMES)
    found = answer(made)
    np.testing.assert_array_equal(unpacked(found["pieces"][0]["numbers"]), np.arange(136, 200))
    assert [found[key] for key in ("came", "estimated")] == [200, 64]
    assert answer(made, after=150)["pieces"] == found["pieces"]
    made.count_drawn(5)
    assert made.totals() == "200 frames came, 64 were estimated, 5 drawn"


def test_lines_that_are_no_frames_are_counted_and_the_first_is_told() -> None:
    made, told = feed([FRAMES[0], "line 2: no", FRAMES[1], "line 4: nothing"])
    found = answer(made)
    assert told == ["line 2: no"]
    assert [found[key] for key in ("came", "malformed", "fault")] == [2, 2, "line 2: no"]
    assert made.totals().endswith("; malformed lines: 2")


def test_a_stream_without_a_frame_and_one_that_breaks() -> None:
    assert answer(feed(["line 1: no"])[0], patience=0)["message"] == "here has ended without a frame."

    def breaks() -> Iterator[Floats]:
        yield FRAMES[0]
        raise ConnectionResetError(104, "Connection reset by peer")

    made, _ = feed(breaks())
    found = answer(made, patience=0)
    assert [found[key] for key in ("state", "message")] == ["broken", "here broke: Connection reset by peer."]
    waiting = answer(feed()[0], patience=0)
    assert waiting["message"] == "Waiting for the first frame of here."


def test_no_more_is_kept_than_there_is_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST", 100)
    steps = iter(range(9))
    waiting = [threading.Event() for _ in range(9)]

    def estimate(stress: Floats) -> Result:
        waiting[next(steps)].wait(10)
        return Tfra.of(DESIGN)(stress)

    made, _ = feed(estimate=estimate)
    for turn in range(3):
        made.read(FRAMES[:40], lambda fault: None)
        waiting[turn].set()
        while made.counts["estimated"] < made.counts["came"]:
            found = answer(made, after=40 * turn - 1)
            waiting[turn + 1].set()
        waiting[turn + 1].clear()
    found = answer(made)
    numbers = np.concatenate([unpacked(piece["numbers"]) for piece in found["pieces"]])
    assert numbers[-1] == 119
    assert 60 <= len(numbers) <= 100


def test_frames_that_are_too_old_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter(float(second) for second in (100, 105, 120))
    monkeypatch.setattr(module.time, "time", lambda: next(now))
    made, _ = feed()
    for number in range(3):
        made.read(FRAMES[:1], lambda fault: None)
        answer(made, after=number - 1)
    numbers = [unpacked(piece["numbers"]).tolist() for piece in answer(made)["pieces"]]
    assert numbers == [[2]]


def test_it_is_not_over_while_frames_are_estimated() -> None:
    """A simulated core takes longer than a page waits."""
    slow = threading.Event()

    def estimate(stress: Floats) -> Result:
        slow.wait(10)
        return Tfra.of(DESIGN)(stress)

    made, _ = feed(FRAMES[:2], estimate=estimate)
    assert not answer(made, patience=0)["over"]
    assert not answer(made, patience=0.05)["over"]
    slow.set()
    assert len(answer(made)["pieces"]) == 1
    assert answer(made, after=1, patience=0)["over"]


def test_a_wrong_number_is_noticed() -> None:
    made, _ = feed(FRAMES[:3] * 1.01)
    (piece,) = answer(made)["pieces"]
    codes, scale = (unpacked(piece["results"][0]["stress"][key]) for key in ("codes", "scale"))
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(codes.reshape(3, 24) * scale[:, None], FRAMES[:3].reshape(3, 24), atol=2)
