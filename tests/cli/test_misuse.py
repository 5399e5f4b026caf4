"""Every case of misuse ends in the one line that it should, changes no file, and says nothing else."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from tfra.cli.main import main

from .misuse import CASES, CONFIG, Misuse


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("good")
    (folder / "skin.toml").write_text(CONFIG)
    assert main(["frames", str(folder / "skin.toml"), "--out", str(folder / "frames.npz")]) == 0
    return (folder / "frames.npz").read_bytes()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_misuse(
    case: Misuse,
    frames: bytes,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG)
    Path("frames.npz").write_bytes(frames)
    case.make()
    before = {path: path.lstat().st_mtime_ns for path in Path().rglob("*")}
    capfd.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main(case.arguments.split()) == case.code
    out, err = capfd.readouterr()
    assert out == ""
    assert case.fragment in err
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert len(err) < 400
    assert {path: path.lstat().st_mtime_ns for path in Path().rglob("*")} == before


def test_cases_are_told_apart() -> None:
    assert len({case.name for case in CASES}) == len(CASES) >= 60
