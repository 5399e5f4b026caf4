"""Blocks of docs/howto that are marked to be run as a whole, with tools beside tfra."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.contacts.tutorial import answer
from tests.docs.test_commands import WHOLE, marked
from tfra.cli.main import main

PARALLEL = ("kind =", "mac_lanes", "vector_words")
"""Keys of a parallel core's architecture; the serial one, which is small, takes seconds in every tool."""


@pytest.mark.long
@pytest.mark.parametrize(("page", "lines"), marked(WHOLE))
def test_blocks(page: str, lines: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    sensor = ["--rows", "3", "--columns", "4", "--pitch-x", "2", "--pitch-y", "2", "--thickness", "2"]
    assert main(["init", *sensor, "--out", "whole.toml"]) == 0
    kept = [line for line in Path("whole.toml").read_text().splitlines() if not line.startswith(PARALLEL)]
    Path("skin.toml").write_text("\n".join(kept).replace("[architecture]", '[architecture]\nkind = "serial"'))
    for line in lines:
        answer(line)
    assert Path("skin.bit").stat().st_size > 100_000


def test_the_blocks_are_found() -> None:
    assert [page for page, _ in marked(WHOLE)] == ["docs/howto/lattice.md"]
