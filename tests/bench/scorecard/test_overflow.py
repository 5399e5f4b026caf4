"""Which words count as safe from an untold overflow."""

import pytest

from bench.scorecard import overflow
from bench.scorecard.overflow import reason
from tfra.study.signals.measures import Word


@pytest.mark.parametrize(
    ("word", "cut", "why"),
    [
        (Word("a", "vector", 8, True, 128.0), 0, "by its bound"),
        (Word("a", "vector", 8, True, 129.0), 0, ""),
        (Word("a", "magnitude", 8, False, 256.0), 0, "by its bound"),
        (Word("a", "magnitude", 8, False, 257.0), 0, ""),
        (Word.full("a", "result", 8), 0, "limited with a flag"),
        (Word.full("a", "result", 8), 1, ""),
        (Word.full("a", "division", 8), 0, "shifted to fit"),
        (Word.full("a", "division", 8), 1, ""),
    ],
)
def test_reasons(word: Word, cut: int, why: str) -> None:
    assert reason(word, {"saturated": cut}) == why


def test_one_signal_without_a_reason_misses_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    reasons = {"b": "by its bound", "phi": ""}
    monkeypatch.setattr(overflow, "judged", lambda design: reasons)
    found = overflow.measure(True)
    assert not found.passed
    assert found.figure == "2 of 4 signals: 2 otherwise, 2 by its bound"
    assert found.facts["otherwise"] == {"small": ["phi"], "learned_small": ["phi"]}
    reasons["phi"] = "shifted to fit"
    assert overflow.measure(True).passed
