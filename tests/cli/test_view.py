"""``tfra view``: the page, the frames that are chosen, and one line for what is wrong."""

import json
from pathlib import Path

import pytest

from tests.cli.test_cli import refusal
from tests.view.made import write
from tfra.cli.main import main


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with two results and their frames."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    return tmp_path


def test_a_page_is_made_and_made_again(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["view", "float.npz", "fixed.npz", "frames.npz", "--out", "page.html"]
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    first = Path("page.html").read_bytes()
    assert out == f"page.html: {len(first) / 1e6:.1f} MB. All 24 frames are shown.\n"
    assert err == ""
    assert main(arguments) == 0
    assert Path("page.html").read_bytes() == first
    assert b"http" not in first.partition(b"<script>")[0]


def test_chosen_frames(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "float.npz", "--out", "page.html", "--frames", "5:20", "--every", "4", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told == {
        "out": "page.html",
        "bytes": Path("page.html").stat().st_size,
        "frames": 24,
        "shown": {"first": 5, "step": 4, "count": 4},
        "sweeps_every": 1,
    }
    assert main(["view", "float.npz", "--out", "page.html", "--frames", "22:", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["shown"] == {"first": 22, "step": 1, "count": 2}


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--frames", "7"], "tfra view: --frames: A:B is needed, whole numbers or nothing, got '7'"),
        (["--frames", "-3:"], "tfra view: --frames: A:B is needed, whole numbers or nothing, got '-3:'"),
        (["--frames", "9:9"], "tfra view: --frames: '9:9' selects none of the frames 0 to 23"),
        (["--out", "page.htm"], "page.htm: the name of the output must end in .html"),
    ],
)
def test_what_is_wrong_is_told(
    folder: Path, capfd: pytest.CaptureFixture[str], arguments: list[str], line: str
) -> None:
    assert refusal(capfd, "view", "float.npz", "--out", "page.html", *arguments) == line


def test_more_than_a_page_tells_apart(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    names = [f"{n}.npz" for n in range(6)]
    for name in names:
        Path(name).write_bytes(Path("float.npz").read_bytes())
    line = "tfra view: RESULT.npz: at most 5 results and 1 file of references, got 6 and 0"
    assert refusal(capfd, "view", *names, "--out", "page.html") == line
