"""The study of a skin from its file to its page: the same bytes in any order, and what the page says."""

import json
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from tests.browser import browser
from tests.study.definitions import one_after_another
from tests.study.skins.definitions import MIXTURE, STUDY, study, write
from tfra.runtime.errors import InputError
from tfra.study.run import run
from tfra.study.studyfile import load_study
from tfra.study.workers import processes

TABLES = {"errors", "finding", "groups", "marked", "uniform", "converter"}


@contextmanager
def silent(name: str, unit: str, jobs: int, there: int) -> Iterator[Any]:
    yield lambda: None


def backwards(do: Callable[[Any], Any], jobs: Sequence[Any]) -> Iterator[tuple[int, Any]]:
    yield from ((number, do(jobs[number])) for number in reversed(range(len(jobs))))


def content(out: Path) -> dict[str, bytes]:
    files = [file for file in out.rglob("*.*") if file.name not in ("times.html", "tfra-manifest.json")]
    return {str(file.relative_to(out)): file.read_bytes() for file in files}


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    told = run(study(folder), folder / "out", folder / "work", nullcontext(one_after_another), "me", silent)
    (folder / "answer").write_text(told["answer"])
    return folder / "out"


def test_any_order_makes_the_same_bytes(report: Path, tmp_path: Path) -> None:
    run(study(tmp_path), tmp_path / "out", tmp_path / "work", nullcontext(backwards), "me", silent)
    made = content(report)
    assert {path.stem for path in (report / "tables").iterdir()} == TABLES
    assert content(tmp_path / "out") == made
    assert b"Still to come" not in made["index.html"]


@pytest.mark.long
def test_one_worker_and_two_make_the_same_bytes(tmp_path: Path) -> None:
    for count in (1, 2):
        run(study(tmp_path), tmp_path / f"out{count}", tmp_path / f"work{count}", processes(count), "", silent)
    assert content(tmp_path / "out1") == content(tmp_path / "out2")


def test_the_answer_has_the_numbers_of_the_tables(report: Path) -> None:
    answer = (report.parent / "answer").read_text().replace("\N{NO-BREAK SPACE}", " ")
    names = [line.partition(":")[0] for line in answer.splitlines()]
    assert names[:3] == ["Asked", "Found", "Limit"]
    assert names[-1] == "Next"
    assert "skin (14×16 taxels, windows of 6×6, 12-bit converter, arithmetic standard)" in answer
    held_out = pl.read_parquet(report / "tables" / "finding.parquet").filter(
        part="held_out", split="all", step="arithmetic", kind="missed"
    )
    count, of = held_out.select("count", "of").row(0)
    share, total = re.search(r"Found: ([\d.]+) % of (\d+) contacts are missed", answer).groups()  # type: ignore[union-attr]
    assert (float(share), int(total)) == (pytest.approx(100 * count / of, rel=0.05), of)


def test_the_page_shows_every_chart(report: Path, tmp_path: Path) -> None:
    with browser(tmp_path) as tab:
        tab.open(report / "index.html")
        drawn = tab.until("document.querySelectorAll('.js-plotly-plot .main-svg').length && "
                          "[...document.querySelectorAll('.js-plotly-plot')].map(each => each.id)")  # fmt: skip
        assert tab.messages == tab.requests == []
    assert drawn == [
        *("chart-finding", "chart-finding-groups", "chart-cascade", "chart-groups", "chart-uniform"),
        *("chart-converter-own", "chart-converter-total", "chart-converter-finding"),
    ]
    charts = json.loads(re.search(r'id="charts"[^>]*>(.*?)</script>', (report / "index.html").read_text())[1])  # type: ignore[index]
    table = pl.read_parquet(report / "tables" / "finding.parquet")
    rates = table.filter(part="train", split="all", step="noise")["rate"].to_list()
    series = charts["chart-finding"]["figures"]["train"]["data"]
    (shown,) = (each for each in series if each["name"] == "noise and offset")
    assert sorted(shown["x"]) == pytest.approx(sorted(rates))


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("[uniform]", "[search]\n[uniform]", "search: a study of a skin has only config, frames, uniform, converter"),
        ("[uniform]", "[sensitivity]\n[uniform]", "sensitivity: a study of a skin has only config, frames, uniform, "),
        ("train = 40", "train = 0", "frames.train: at least one is needed, got none"),
        (
            "to = 4 }",
            "to = 5 }",
            "frames.mixture#1.contacts: whole numbers of 1 to 4 are needed, most of ",
        ),
        ("from = 1,", "from = 1.5,", "frames.mixture#1.contacts: whole numbers of 1 to 4 are needed"),
        ("to = 4 }", "to = 4, log = true }", "frames.mixture#1.contacts: a range upwards without log is needed"),
        ("from = 1, to = 4", "from = 3, to = 2", "frames.mixture#1.contacts: a range upwards without log is needed"),
        ("gap_pitches = 0.5", "gap_pitches = -1", "frames.mixture#1.gap_pitches: "),
        (MIXTURE, 'recording = "x.npz"\n', "frames.recording: of a skin the contacts of every frame must be known"),
        (MIXTURE, "", "frames.mixture: is missing"),
    ],
)
def test_what_is_wrong_is_one_line(tmp_path: Path, old: str, new: str, line: str) -> None:
    assert old in STUDY
    with pytest.raises(InputError) as caught:
        load_study(write(tmp_path, STUDY.replace(old, new)))
    assert str(caught.value).removeprefix(f"{tmp_path}/").startswith(f"study.toml: {line}")


def test_frames_that_no_crowd_fits_on_leave_nothing(tmp_path: Path) -> None:
    crowded = STUDY.replace("gap_pitches = 0.5", "gap_pitches = 9.0").replace("from = 1, to = 4", "from = 3, to = 4")
    with pytest.raises(InputError, match=r"study.toml: frames.mixture#1.contacts: \d contacts with a gap of 9 pitches"):
        run(study(tmp_path, crowded), tmp_path / "out", tmp_path / "w", nullcontext(one_after_another), "", silent)
    assert not (tmp_path / "out").exists()


def test_keys_of_a_skin_belong_to_skins(tmp_path: Path) -> None:
    one = "[sensor]\nrows = 4\ncolumns = 6\npitch_x_mm = 5.0\npitch_y_mm = 3.0\nthickness_mm = 2.0\n"
    with pytest.raises(InputError, match=r"mixture#1.contacts: a frame has one contact, since CONFIG has no section"):
        load_study(write(tmp_path, STUDY, one))


def test_contacts_beyond_full_scale_are_told(tmp_path: Path) -> None:
    pressed = STUDY[: STUDY.index("[uniform]")].replace("to = 100.0", "to = 900.0").replace("= 70", "= 0")
    run(study(tmp_path, pressed), tmp_path / "out", tmp_path / "w", nullcontext(one_after_another), "", silent)
    bits = pl.read_parquet(tmp_path / "out" / "tables" / "marked.parquet").filter(step="arithmetic")
    ((count, of),) = bits.filter(status="input_saturated").select("contacts", "of").rows()
    assert 0 < count < of
    assert f"{count} of {of} contacts found have a taxel at an end" in (tmp_path / "out" / "index.html").read_text()
