"""Every case of misuse is answered as written in ``misuse/answers.json`` and docs/misuse.md, and changes no file."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from tests.cli.misuse.cases import ANSWERS, CASES, Misuse, answer, good_frames

PUBLISHED = json.loads(ANSWERS.read_text())


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
        code, out, err = answer(replace(case, make=make), frames)
    assert code == case.code
    assert err == PUBLISHED[case.name]
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


def test_cases_have_names_of_their_own() -> None:
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names) >= 80
    assert list(PUBLISHED) == names


def test_the_page_shows_answers() -> None:
    """Each row of docs/misuse.md is a case with its command, answer and exit code."""
    page = (Path(__file__).parents[2] / "docs" / "misuse.md").read_text()
    rows = [line for line in page.splitlines() if line.startswith("| ") and "`" in line]
    lines = {case.name: "<br>".join(f"`` {each} ``" for each in PUBLISHED[case.name].splitlines()) for case in CASES}
    known = {f"| {case.name} | `{case.arguments}` | {lines[case.name]} | {case.code} |" for case in CASES}
    assert len(rows) > 50
    assert [row for row in rows if row.replace("¦", "|") not in known] == ["| what is wrong | `tfra` | answer | exit |"]
