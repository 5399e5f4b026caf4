"""A step is done once: what it found and its files come back, and only for the same name and key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tfra.synth.kept import once
from tfra.synth.tools import ToolError


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path / "cache"))


def test_once(tmp_path: Path) -> None:
    calls = []

    def step(directory: Path) -> dict[str, Any]:
        calls.append(directory)
        (directory / "tool.log").write_bytes(b"\x00words\n" * 1000)
        return {"mhz": 1.5, "path": {"begin": "sweep"}}

    first, second = tmp_path / "first", tmp_path / "second"
    for directory, was_kept in ((first, False), (second, True)):
        directory.mkdir()
        (directory / "before").write_text(directory.name)
        found = once("yosys-skin", "0" * 16, directory, lambda directory=directory: step(directory))
        assert found == ({"mhz": 1.5, "path": {"begin": "sweep"}}, was_kept)
    assert calls == [first]
    assert (second / "tool.log").read_bytes() == (first / "tool.log").read_bytes()
    assert (second / "before").read_text() == "second"
    once("yosys-skin", "1" * 16, second, lambda: step(second))
    assert calls == [first, second]


def test_what_failed_is_not_kept(tmp_path: Path) -> None:
    def fail() -> dict[str, Any]:
        raise ToolError("no")

    with pytest.raises(ToolError):
        once("route-skin", "0" * 16, tmp_path, fail)
    assert once("route-skin", "0" * 16, tmp_path, lambda: {"mhz": 2}) == ({"mhz": 2}, False)
