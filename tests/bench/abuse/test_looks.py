"""A look at an output sees what is wrong with it; three writers at work give it nothing to see."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.abuse.looks import KINDS, look, looks


@pytest.mark.parametrize("kind", KINDS)
def test_looks_while_writers_write(kind: str) -> None:
    assert set(looks(kind, 50)) <= {"whole", "exchanged"}


def test_a_look_sees_half_an_output(tmp_path: Path) -> None:
    write, objection = KINDS["directory"]
    out = tmp_path / "out"
    assert look(out, objection) == "absent"
    write(out, 1)
    assert look(out, objection) == "whole"
    (out / "lane_7.hex").write_bytes(b"half")
    assert look(out, objection) == "lane_7.hex in it has changed since tfra wrote it"
