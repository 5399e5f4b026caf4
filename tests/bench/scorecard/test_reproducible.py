"""Bytes that differ are told by their files, and a Python that is not there is no success."""

from pathlib import Path

import pytest

from bench.scorecard import reproducible
from bench.scorecard.reproducible import VARIABLES, unequal


def test_unequal() -> None:
    assert unequal({"a": "1", "b": "2"}, {"a": "1", "b": "2"}) == []
    assert unequal({"a": "1", "b": "2"}, {"a": "3", "c": "4"}) == ["a", "b", "c"]


def test_a_file_that_follows_the_time_zone_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(folder: Path, python: str, example: str, kind: str, variables: dict[str, str]) -> dict[str, str]:
        return {"core.v": "1", "date": variables.get("TZ", "")}

    monkeypatch.setattr(reproducible, "made", made)
    found = reproducible.measure(True)
    assert not found.passed
    assert found.facts["different"] == [
        f"learned_small, {kind}, another time zone: date" for kind in reproducible.KINDS
    ]
    ways = len(VARIABLES) + 1
    assert found.figure == f"4 files, {ways} ways each: 2 of {4 * ways} differ"


def test_a_python_that_is_missing_misses_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproducible, "made", lambda *given: {"core.v": "1"})
    monkeypatch.setattr(reproducible, "pythons", lambda folder: [("3.12", "python"), ("3.13", "")])
    found = reproducible.measure(False)
    assert not found.passed
    assert found.figure.endswith("0 of 36 differ; not run: Python 3.13")
    monkeypatch.setattr(reproducible, "pythons", lambda folder: [("3.12", "python")])
    assert reproducible.measure(False).passed
