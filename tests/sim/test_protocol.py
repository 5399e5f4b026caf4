"""Stalls, stream rules, comparison and the files of a job: all without a simulator."""

from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import pytest

from tfra.sim.protocol import MOST_NOTES, Job, Outcome, Probe, Record, stalls

WORDS = 3


def made(frames: int = 2, **changes: Any) -> Record:
    """A record of some frames of four taxels and ``WORDS`` words; every look at its clock is one cycle later."""
    clock = iter(range(100))
    return Record(Job(list(range(4 * frames)), 4, WORDS, frames, **changes), lambda: next(clock))


def test_patterns_are_reproducible_and_stall_as_named() -> None:
    first = {name: list(islice(stalls(name, 7, "taxel"), 2000)) for name in ("none", "random", "bursts")}
    assert first == {name: list(islice(stalls(name, 7, "taxel"), 2000)) for name in first}
    assert first["random"] != list(islice(stalls("random", 8, "taxel"), 2000))
    assert first["random"] != list(islice(stalls("random", 7, "result"), 2000))
    assert not any(first["none"])
    changes = {name: sum(a != b for a, b in pairwise(p)) for name, p in first.items()}
    assert 900 < sum(first["random"]) < 1100
    assert changes["random"] > 900
    assert 600 < sum(first["bursts"]) < 1400
    assert 60 < changes["bursts"] < 300


def test_unknown_pattern() -> None:
    with pytest.raises(ValueError, match="stall: one of none, random, bursts is needed, got 'often'"):
        stalls("often", 0, "taxel")


@pytest.mark.parametrize(
    ("steps", "note"),
    [
        ([(5, 0, False), None], "frame 0, word 0: valid was withdrawn before the word was taken"),
        (
            [(5, 0, True), (6, 0, False), (7, 0, True)],
            "frame 0, word 1: payload changed from (6, 0) to (7, 0) before it was taken",
        ),
        (
            [(5, 0, False), (5, 1, True)],
            "frame 0, word 0: payload changed from (5, 0) to (5, 1) before it was taken",
        ),
        ([(5, 0, True), (6, 1, True)], "frame 0, word 1: last is set too early"),
        ([(5, 0, True), (6, 0, True), (7, 0, True)], "frame 0, word 2: last is missing"),
    ],
)
def test_each_broken_rule_is_noted(steps: list[tuple[int, int, bool] | None], note: str) -> None:
    record = made()
    for step in steps:
        if step is None:
            record.idle()
        else:
            record.word(*step)
    assert record.outcome.violations[0] == note


def test_notes_are_limited_but_all_are_counted() -> None:
    record = made()
    for _ in range(MOST_NOTES + 5):
        record.surplus()
    assert record.close().violations[MOST_NOTES - 1 :] == [
        f"a word follows the last frame, of {WORDS} words",
        f"... {MOST_NOTES + 5} in all",
    ]


def test_a_clean_stream_breaks_no_rule_and_marks_frames() -> None:
    record = made(expected=list(range(6)))
    for _ in range(8):
        record.taxel_sent()
    assert record.outcome.last_taxel == [0, 1]
    ends = []
    for number in range(6):
        last = number % WORDS == 2
        assert not record.word(number, last, ready=False)
        ends.append(record.word(number, last, ready=True))
        record.idle()
    assert ends == [False, False, True] * 2
    assert (record.missing, record.transfers) == (0, 14)
    assert record.close() == Outcome(list(range(6)), [], 6, 0, [0, 1], [2, 4], [3, 5], 6)


@pytest.mark.parametrize(
    ("expected", "words", "counts"),
    [([1, 2, 3, 4], [1, 9, 3, 8, 5], (4, 2)), ([1, 2, 3], [1, 2], (2, 0)), (None, [1], (0, 0))],
)
def test_words_are_compared_in_order(expected: list[int] | None, words: list[int], counts: tuple[int, int]) -> None:
    record = made(expected=expected)
    for word in words:
        record.word(word, 0, True)
    outcome = record.close()
    assert (outcome.words, (outcome.compared, outcome.mismatches)) == (words, counts)


def test_a_hang_says_how_far_it_came() -> None:
    record = made(patience=50)
    record.taxel_sent()
    record.hung()
    assert record.close().violations == ["no transfer in 50 cycles after 0 of 6 words and 1 of 8 taxels"]


def test_job_and_outcome_survive_their_files(tmp_path: Path) -> None:
    probe = Probe("sweep", "core.t", "core.w", [[5, False], [3, True]], 2)
    sent = made(seed=3, stall_in="bursts", probes=[probe]).job
    sent.save(tmp_path / "job.json")
    assert Job.load(tmp_path / "job.json") == sent
    outcome = Outcome([1, 2], ["note"], 2, 1, [3], [4], [5], 6, [[1 << 100]])
    outcome.save(tmp_path / "outcome.json")
    assert Outcome.load(tmp_path / "outcome.json") == outcome
    assert [file.name for file in tmp_path.glob("*outcome*")] == ["outcome.json"]


def test_probe_unpacks_the_first_word_lowest() -> None:
    probe = Probe("s", "t", "w", ((4, True), (3, False)), 1)
    assert probe.unpack([0b111_1000, 0b010_0111]) == [-8, 7, 7, 2]
