"""Every case of misuse is answered as docs/misuse.md has it, and changes no file."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from bench.abuse.misuse import CASES, Misuse, answer, good_frames, published


@pytest.fixture(scope="module")
def frames() -> bytes:
    return good_frames()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_misuse(case: Misuse, frames: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    before: dict[Path, int] = {}
    made = case.make

    def make() -> None:
        made()
        before.update({path: path.lstat().st_mtime_ns for path in Path().rglob("*")})

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code, out, err = answer(Misuse(case.name, make, case.arguments, case.fragment, case.code), frames)
    assert code == case.code
    assert case.fragment in err
    assert err == published()[case.name]
    assert all(len(line) < 400 for line in err.splitlines())
    after = {path: path.lstat().st_mtime_ns for path in Path().rglob("*")}
    if case.code:
        assert out == ""
        assert err.count("\n") == 1
        assert after == before
    else:
        doubted = "tfra init" if case.arguments.startswith("init") else "wrong.npy"
        assert all(line.startswith(f"warning: {doubted}: ") for line in err.splitlines())
        assert after.keys() - before.keys() == {Path("r.npz")} & {Path(name) for name in case.arguments.split()}
        assert {path: after[path] for path in before} == before


def test_cases_are_told_apart() -> None:
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names) >= 80
    assert list(published()) == names
