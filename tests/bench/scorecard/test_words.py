"""The harness of line 1: equal words pass, a planted wrong one is found, shrunk, and counted."""

from pathlib import Path

import numpy as np
import pytest

from bench.scorecard.words.drawn import drawn
from bench.scorecard.words.harness import Configuration, Harness, Outcome, replayed
from bench.scorecard.words.measure import directed, shrunk, wrong_words
from tfra.model.choices import Adc, Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

SMALL = Configuration(
    "small",
    TfraDesign(SensorArray(2, 2, 4e-3, 2e-3, 3e-3), "c", adc=Adc(8), search=Search(1), architecture=Architecture(4)),
)
PLANTED = "(taxel_data)", "(taxel_data ^ (taxel_data == 8'h85))"
"""A code of -123 is taken for one of -124."""


def test_drawn_configurations_are_of_every_kind_and_always_the_same() -> None:
    found = list(drawn(12, 1))
    assert {one.design.estimator for one in found} == {"tfra", "learned"}
    assert {one.design.architecture.kind for one in found} == {"parallel", "serial"}
    assert sum(one.wrapped for one in found) == 4
    assert len({repr(one.design.formats) for one in found}) == 12
    assert [repr(one.design) for one in found] == [repr(one.design) for one in drawn(12, 1)]


def test_a_wrong_word_of_the_c_is_found_by_the_replay() -> None:
    codes = directed(SMALL)[-5:]
    words = SMALL.design.model(codes).words.copy()
    right = Outcome({}, codes.reshape(5, -1), list(words))
    assert replayed(SMALL, right) == (5 * (SMALL.design.frame_words - 1), 0)
    words[3, 2] ^= 1
    words[2, 0] += 7  # a counter, which the harness itself checks
    assert replayed(SMALL, Outcome({}, codes.reshape(5, -1), list(words)))[1] == 1


def test_every_kind_of_error_counts() -> None:
    record = {"differ": 0, "broken": 0, "missing": 0, "replayed_differ": 0, "icarus": {"differ": 0}}
    assert wrong_words(record) == 0
    for name in ("differ", "broken", "missing", "replayed_differ"):
        assert wrong_words(record | {name: 3}) == 3
    assert wrong_words(record | {"icarus": {"differ": 2}}) == 2


@pytest.mark.long
def test_a_planted_word_is_found_and_shrunk(tmp_path: Path) -> None:
    (tmp_path / "good").mkdir()
    (tmp_path / "bad").mkdir()
    good = Harness(SMALL, tmp_path / "good").run(directed(SMALL), 2000, 1)
    assert good.passed
    assert good.counts["words"] == (len(directed(SMALL)) + 2000) * SMALL.design.frame_words
    assert replayed(SMALL, good)[1] == 0
    texts = {name: text.replace(*PLANTED) for name, text in SMALL.texts.items()}
    assert texts != SMALL.texts
    bad = Harness(SMALL, tmp_path / "bad", texts=texts)
    found = bad.run(directed(SMALL), 2000, 1)
    assert found.counts["differ"] > 0
    assert -123 in found.counts["codes"]
    assert found.counts["expected"] != found.counts["got"]
    least = shrunk(bad, np.array([5, -123, 70, -50]))
    assert least is not None
    assert least.tolist() == [[0, -123], [0, 0]]
    assert shrunk(bad, np.array([5, -122, 70, -50])) is None
