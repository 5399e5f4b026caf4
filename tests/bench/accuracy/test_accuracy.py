"""From observations to the page: percentiles, verdicts, tables, and the record that they tell."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.accuracy import accuracy, estimators, measure
from bench.accuracy.estimators import FIXED, LEARNED, NAMES
from bench.accuracy.scenes import NOISES, QUIET, SCENES, SEED, cases, scenes
from bench.accuracy.tables import Target, furthest, tables, verdict
from bench.publish import ROOT, stored
from tests.bench.accuracy.random_case import random_case
from tfra.train.heldout import Resultants


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    found: dict[str, Any] = stored("accuracy")
    return found


def told(name: str, page: str = accuracy.PAGE) -> str:
    """What stands between the marks of the page."""
    _, _, rest = (ROOT / page).read_text().partition(f"<!-- {name} -->\n")
    text, mark, _ = rest.partition(f"\n<!-- end {name} -->")
    assert mark, f"<!-- {name} --> is missing"
    return text


def test_the_page_tells_the_record(kept: dict[str, Any]) -> None:
    for name, table in tables(kept).items():
        assert told(name) == table, name
    assert told(accuracy.SHORT, "README.md") == told(accuracy.SHORT)


def test_the_kept_record_is_of_this_list(kept: dict[str, Any]) -> None:
    assert kept["seed"] == SEED
    assert kept["contacts"] == accuracy.COUNT
    for row in (kept["pooled"], *(sensor["scenes"] for sensor in kept["sensors"].values())):
        assert list(row) == list(SCENES)
        assert all(list(scene) == list(NAMES) for scene in row.values())
    every = cases()
    assert [case.name for case in every] == list(kept["sensors"])
    for case in every:
        assert accuracy.described(case).items() <= kept["sensors"][case.name].items()


def test_today_the_learned_estimators_are_as_accurate(kept: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(estimators, "FITTED", 50)
    for case in cases():
        every = estimators.estimators(case)
        name, codes, force = next(scenes(case, accuracy.COUNT))
        for who in (LEARNED, FIXED):
            off = measure.percentiles({name: {who: measure.compared(Resultants(force), every[who](codes))}})
            for key, both in off[name][who].items():
                assert both == pytest.approx(kept["sensors"][case.name]["scenes"][name][who][key], rel=0.01), key


@pytest.mark.long
def test_a_whole_record(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(estimators, "FITTED", 50)
    monkeypatch.setattr(measure, "PAPER", ("small",))
    found = accuracy.record([random_case(), random_case("other")], 40)
    again = json.loads(json.dumps(found))
    assert again == found
    row = found["sensors"]["small"]["scenes"][QUIET]
    assert all(0 <= low <= high for who in row.values() for low, high in who.values())
    assert found["sensors"]["other"]["paper"] is None
    assert list(found["sensors"]["small"]["paper"][QUIET]) == ["0.1", "0.3", "0.5", "0.7", "0.9"]
    assert {len(curve) for noise in found["curves"].values() for curve in noise.values()} == {measure.BINS}
    for table in tables(found).values():
        assert len({line.count("|") - line.count("\\|") for line in table.splitlines() if "|" in line}) == 1
    monkeypatch.setattr(accuracy, "ROOT", tmp_path)
    (tmp_path / "bench" / "results").mkdir(parents=True)
    accuracy.plot(found["curves"])
    assert {file.name for file in (tmp_path / "bench" / "results").iterdir()} == {"accuracy.svg"}


def observation(mu: float) -> dict[str, Any]:
    """A hundred frames with the error ``mu`` of a perfect estimator's friction."""
    true = np.linspace(0, 0.99, 100)
    values = {"mu_true": true, "mu_found": true + mu, "mu": np.full(100, mu)}
    values |= {"phi_deg": np.arange(100.0), "force_percent": np.zeros(100)}
    return {noise: dict.fromkeys(NAMES, values) for noise in NOISES}


def test_pooled_percentiles() -> None:
    both = measure.pooled([observation(0.1), observation(0.3)])
    assert len(both[QUIET][LEARNED]["mu"]) == 200
    row = measure.percentiles(both)[QUIET][LEARNED]
    assert row["mu"] == pytest.approx([0.2, 0.3])
    assert row["phi_deg"] == pytest.approx([49.5, 94.05], abs=0.6)
    curve = measure.curves(observation(0.1))[QUIET][LEARNED]
    assert np.array(curve)[:, 1] == pytest.approx(np.arange(10) / 10 + 0.045 + 0.1)


def test_differences_notice_single_frames() -> None:
    mu = np.linspace(0, 0.99, 100)
    exact = SimpleNamespace(mu=mu, phi_deg=np.zeros(100), resultant=np.zeros((100, 3)))
    other = SimpleNamespace(mu=mu.copy(), phi_deg=np.zeros(100), resultant=np.zeros((100, 3)))
    assert measure.differences(exact, other, mu) == {"mu": 0, "phi_deg": 0}
    other.phi_deg[:6], other.mu[-6:] = 359.0, 2.0  # the first six have a friction of 0.05 at most
    found = measure.differences(exact, other, mu)
    assert found["mu"] > 1
    assert found["phi_deg"] == 0


def test_verdicts() -> None:
    assert verdict(0.02, 0.02, 3) == "0.020 ✓"
    assert verdict(0.0313, 0.03, 3) == "0.031 (+0.0013)"
    assert verdict(2.5, 2.0, 1) == "2.5 (+0.5)"
    assert verdict(0.03001, 0.03, 3) == "0.030 (+0.00001)"
    fine = Target(QUIET, "mu", 95, 0.09, 0.14)
    assert (fine.limit_of(1.29), fine.limit_of(1.3)) == (0.09, 0.14)
    sensor = {"scenes": {QUIET: {LEARNED: {"mu": [0.01, 0.08]}}}}
    assert fine.found(sensor) == 0.08
    assert furthest({"0.3": 0.31, "0.7": 0.65}) == pytest.approx(0.05)
