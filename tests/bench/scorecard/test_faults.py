"""Line 8: faults are told when they are, and only then; settings that are off tell nothing."""

from typing import Any

import numpy as np
import pytest

from bench.scorecard.faults import measure
from bench.scorecard.faults.host import told as warned
from bench.scorecard.faults.measure import Bench, alarms, of_stream, small, told, wrong_tables
from bench.scorecard.faults.player import Heard, Player, heard, read, sent, wait, write
from bench.scorecard.faults.streams import EVERY, FAULTS, LAST, Stream, clean, planted, same_words, stuck_frames
from tfra.model.arrays import Ints

STUCK, GAP, STALE, SATURATION = 1 << 9, 1 << 5, 1 << 4, 1 << 2


def said(alarms: Ints, faulty: Ints | None = None) -> Heard:
    none = np.zeros(len(alarms), dtype=np.int64)
    return Heard(alarms, alarms, none if faulty is None else faulty, none, none)


def test_the_first_alarm_from_a_fault_on_counts() -> None:
    found, faulty = np.zeros((2, 4 * EVERY), dtype=np.int64)
    found[[9, 10, 74, 141]] = GAP, STUCK | SATURATION, STUCK, STUCK  # the first is before the first fault
    faulty[10] = 3 | 1 << 18
    at = np.array([10, 70, 140, 200])
    assert told(said(found, faulty), at, np.array([3, 0, 1, 0])) == {
        "planted": 4, "at_once": 1, "later": 2, "never": 1, "by": {"stuck": 3, "saturation": 1}, "named": 2,
        "median": 2.5, "most": 4,
    }  # fmt: skip
    found[:] = 0
    found[10 + LAST + 4] = GAP  # too late for the first fault
    assert told(said(found), at[:1])["never"] == 1


def test_answers_are_those_of_their_slots() -> None:
    frame = np.array([0, 50, 7, 2, 11, 12])
    script = np.concatenate([write("STUCK", 3), frame, wait(9), frame, read("STUCK"), frame])
    assert sent(script).tolist() == [0, 2, 3]
    format_1 = 1 << 24
    answers = np.array([
        [1, 0, 0, 0], [1, STALE, 0, 0], [0, format_1, 0 | 7 << 16, 64], [1, SATURATION, 5, 0], [2, 3, 0, 0],
        [0, format_1 | STUCK, 2 | 7 << 16, 1], [1, 0, 0, 0],
    ])  # fmt: skip
    found = heard(answers, sent(script))  # frame 1 was dropped
    assert found.alarms.tolist() == [SATURATION, STALE, 0, STUCK]
    assert found.errors.tolist() == [0, STALE, SATURATION, 0]
    assert found.status.tolist() == [64, -1, -1, 1]
    assert found.faulty.tolist() == [0, 0, 5, 0]
    assert found.values.tolist() == [3]


def test_frames_until_a_taxel_is_stuck() -> None:
    assert same_words(1e-9, 5) == pytest.approx(1)
    rng = np.random.default_rng(1)
    words = np.rint(rng.normal(size=(200_000, 3)))
    assert same_words(1.0, 3) == pytest.approx((np.ptp(words, axis=1) == 0).mean(), rel=0.05)
    least = stuck_frames(2.0, 1e6)
    assert 1e6 * same_words(2.0, least) < 0.01 < 1e6 * same_words(2.0, least - 1)
    assert stuck_frames(0.1, 1e6) == 0


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_planted_where_they_say(name: str) -> None:
    before, after = (clean(small(), 4 * EVERY, 200, np.random.default_rng(1)) for _ in range(2))
    at, taxels = planted(after, FAULTS[name], np.random.default_rng(2))
    changed = (before.words != after.words) | (before.users - np.arange(len(before.users)) != 0)[:, None]
    first = {int(slot) for slot in np.flatnonzero(changed.any(axis=1))} | set(after.odd)
    assert min(first) in range(at[0], at[0] + LAST)
    assert len(after.script()) > 0
    if name.startswith("taxel"):
        assert set(np.flatnonzero(changed.any(axis=0))) <= set(taxels)


def test_a_host_is_warned_of_a_stuck_taxel_and_not_of_a_wrong_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    names = "taxel stuck anywhere", "bit of a word wrong"
    monkeypatch.setattr("bench.scorecard.faults.host.FAULTS", {name: FAULTS[name] for name in names})
    found = warned(measure.trained(), 2, 1)
    assert [found[name]["told"] for name in names] == [2, 0]


def test_one_class_that_is_told_too_late_misses_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    one = {"planted": 3, "at_once": 3, "later": 0, "never": 0, "by": {"stuck": 3}, "named": 0}
    none = one | {"at_once": 0, "never": 3, "by": {}}
    record: dict[str, Any] = {
        "array": "4×4",
        "clean": {"frames": 9, "false": 0, "missing": 0},
        "classes": {"none": none, "a": one, "b": dict(one)},
    }
    monkeypatch.setattr(measure, "array", lambda *_: record)
    assert measure.measure(True).passed
    record["classes"]["b"] |= {"at_once": 2, "later": 1}
    found = measure.measure(True)
    assert not found.passed
    assert found.facts["missed"] == ["b"]
    assert found.figure.startswith("1 of 2 classes are told within a frame, 1 later, 0 not or not always; 0 false")
    record["classes"]["b"] = one
    record["clean"]["false"] = 1
    assert not measure.measure(True).passed


@pytest.fixture(scope="module")
def player(tmp_path_factory: pytest.TempPathFactory) -> Player:
    return Player(small(), tmp_path_factory.mktemp("faults"))


@pytest.mark.long
def test_settings_that_are_off_tell_nothing(player: Player) -> None:
    on, off = (Bench(player, stuck, np.random.default_rng(1), stuck > 0) for stuck in (14, 0))
    for name in ("taxel stuck anywhere", "frame repeated with its number"):
        assert of_stream(on, name, 3)["never"] == 0
        assert of_stream(off, name, 3)["never"] == 3
    assert of_stream(on, "taxel stuck anywhere", 3)["named"] == 3
    assert next(wrong_tables(on, 2))[1]["never"] == 2


@pytest.mark.long
def test_a_planted_fault_is_an_alarm_among_clean_frames(player: Player, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(player, 14, np.random.default_rng(1))
    assert alarms(bench, 500) == {"frames": 500, "false": 0, "missing": 0}
    draw = bench.stream

    def faulty(count: int) -> Stream:
        stream = draw(count)
        stream.words[100:130, 3] = stream.words[100, 3]
        return stream

    monkeypatch.setattr(bench, "stream", faulty)
    assert alarms(bench, 500) == {"frames": 500, "false": 17, "missing": 0, "stuck": 17}
