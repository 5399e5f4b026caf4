"""``tfra paper``: tables against their sources, equal bytes in two runs, and the page in a browser."""

import csv
import fcntl
import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import browser
from tests.marks import long
from tfra.cli.main import main
from tfra.model.cover.contact import Contact
from tfra.model.sensor import SensorArray
from tfra.paper.picture import rounded, to_csv
from tfra.paper.published import PRINTED
from tfra.paper.report import report
from tfra.paper.setups import setups
from tfra.paper.surfaces import cell_means
from tfra.runtime.ownership import MANIFEST

ROOT = Path(__file__).parents[2]
SOURCES = {"table1": "table1_hertzian.csv", "table2": "table2_nonhertzian.csv"}
FIGURES = ("fig2", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "sptfra")
ENGINES = ("TFRA, float", "TFRA, bit-accurate", "two-variable, own reading")


@pytest.fixture(scope="module")
def folder(builds: Path) -> Path:
    """One report, which all processes of this run share."""
    out = builds / "paper"
    with (builds / "paper.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not out.exists():
            report(out, repeats=1)
    return out


def rows(path: Path) -> list[list[str]]:
    """A CSV file without comments."""
    return list(csv.reader(line for line in path.read_text().splitlines() if not line.startswith("#")))


def page_table(text: str, name: str) -> list[list[str]]:
    """The body of a table of the page."""
    (body,) = re.findall(rf'<table data-csv="{name}.csv">.*?</thead>(.*?)</table>', text, re.S)
    lines = re.findall(r"<tr[^>]*>(.*?)</tr>", body, re.S)
    return [[html.unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", line)] for line in lines]


def compare(folder: Path, text: str) -> None:
    """Raise ``AssertionError`` unless every table of the page ``text`` is its CSV file."""
    for name in SOURCES:
        for table in (name, f"{name}_maxima"):
            assert page_table(text, table) == rows(folder / f"{table}.csv")[1:]


def published(folder: Path, table: str) -> None:
    """Raise ``AssertionError`` unless ``table`` repeats the published cells as they are."""
    source = sorted(rows(ROOT / "paper" / "data" / SOURCES[table])[1:], key=lambda row: float(row[1]))
    names = {"published TFRA": "tfra", "published two-variable [7]": "ref7"}
    # the columns of a published row, without the errors
    found = [
        [names[row[1]], row[0], *(row[n] for n in (2, 3, 5, 6, 8, 9, 11, 12, 14))]
        for row in rows(folder / f"{table}.csv")[1:]
        if row[1] in names
    ]
    assert found == source


def test_files(folder: Path) -> None:
    figures = {f"{name}.{kind}" for name in FIGURES for kind in ("csv", "svg")}
    tables = {f"{name}{part}.csv" for name in SOURCES for part in ("", "_maxima")}
    rest = {"fig9.html", "index.html", "paper.json", MANIFEST}
    assert {path.name for path in folder.iterdir()} == figures | tables | rest
    assert json.loads((folder / "paper.json").read_text())["generator"].startswith("tfra ")


def test_page_shows_the_tables(folder: Path) -> None:
    text = (folder / "index.html").read_text()
    compare(folder, text)
    with pytest.raises(AssertionError):
        compare(folder, text.replace("<td>2.51</td>", "<td>2.52</td>", 1))


@pytest.mark.parametrize("table", SOURCES)
def test_published_numbers_are_literal(folder: Path, table: str, tmp_path: Path) -> None:
    published(folder, table)
    corrupted = (folder / f"{table}.csv").read_text().replace("-6.72", "-6.73").replace("-5.35", "-5.36")
    (tmp_path / f"{table}.csv").write_text(corrupted)
    with pytest.raises(AssertionError):
        published(tmp_path, table)


@pytest.mark.parametrize("table", SOURCES)
def test_errors_follow_from_the_cells(folder: Path, table: str) -> None:
    """Eqs. 33-35 written out, within the rounding of the cells."""
    for row in rows(folder / f"{table}.csv")[1:]:
        reference, found = (np.array([float(row[n]) for n in places]) for places in ((2, 5, 8), (3, 6, 9)))
        errors = [float(row[n]) for n in (4, 7, 10)]
        np.testing.assert_allclose(errors, 100 * abs(reference - found) / (found @ found) ** 0.5, atol=0.2)
        assert float(row[13]) == pytest.approx(100 * abs(float(row[11]) - float(row[12])), abs=0.06)
        turn = abs(float(row[0]) - float(row[14]))
        assert float(row[15]) == pytest.approx(turn / 3.6, abs=0.006)
        phi, mu, newtons, percent = (float(cell) for cell in row[16:])
        length = float(np.linalg.norm(found - reference))
        assert phi == pytest.approx(turn, abs=0.011)
        assert mu == pytest.approx(abs(float(row[11]) - float(row[12])), abs=6e-4)
        assert newtons == pytest.approx(length, abs=0.02)
        assert percent == pytest.approx(100 * length / np.linalg.norm(reference), abs=0.3)


@pytest.mark.parametrize(("table", "example"), [("table1", "hertz_40x20"), ("table2", "rectangle_40x40")])
def test_maxima(folder: Path, table: str, example: str) -> None:
    """They are the largest of the table, and TFRA's are not above the published ones."""
    maxima = {row[0]: [float(cell) for cell in row[1:4]] for row in rows(folder / f"{table}_maxima.csv")[1:]}
    plain = {row[0]: [float(cell) for cell in row[4:] if cell] for row in rows(folder / f"{table}_maxima.csv")[1:]}
    assert plain["printed in the paper's text"] == []
    limits = list(PRINTED[example].values())
    assert maxima["printed in the paper's text"] == limits
    for method in (*ENGINES, "published TFRA"):
        mine = [row for row in rows(folder / f"{table}.csv")[1:] if row[1] == method]
        assert len(mine) == 8
        columns = [max(float(row[n]) for row in mine) for n in (4, 7, 10, 13, 15)]
        name = method if method in maxima else f"{method}, recomputed"
        assert plain[name] == [max(float(row[n]) for row in mine) for n in range(16, 20)]
        assert maxima[name] == [max(columns[:3]), *columns[3:]]
    for method in ENGINES[:2]:
        assert all(np.less_equal(maxima[method], limits))
    assert not all(np.less_equal(maxima[ENGINES[2]], limits))  # the comparison can fail


def test_the_guide_shows_the_maxima(folder: Path) -> None:
    both = [{r[0]: r[1:4] for r in rows(folder / f"{table}_maxima.csv")} for table in SOURCES]
    names = {
        "stated in the paper": "printed in the paper's text",
        "recomputed from its tables": "published TFRA, recomputed",
        "float": "TFRA, float",
        "bit-accurate, `standard`": "TFRA, bit-accurate",
    }
    text = (ROOT / "docs" / "studies" / "paper.md").read_text()
    for shown, method in names.items():
        assert f"| {shown} | {' | '.join(both[0][method] + both[1][method])} |\n" in text


def test_fig4_chooses_on_the_plateau(folder: Path) -> None:
    mu, b_z, b_xy, plateau = np.loadtxt(folder / "fig4.csv", delimiter=",", skiprows=1).T
    np.testing.assert_array_equal(mu, np.arange(101) / 100)
    np.testing.assert_array_equal(plateau == 1, b_z == b_z.min())
    assert 1 < plateau.sum() < 101
    assert (b_xy >= 0).all()


def test_load_of_a_cell_keeps_the_force() -> None:
    sensor = SensorArray(5, 6, 4e-3, 3e-3, 3e-3)
    contact = Contact("uniform", 9e-3, 6e-3, 5e-3, 4e-3, -3.0, 0.4, 0.7)
    total = cell_means(sensor, contact).sum(axis=(1, 2)) * sensor.taxel_area
    np.testing.assert_allclose(total, contact.force, rtol=0.03)


def test_shifted_contact() -> None:
    hertz = setups()[0]
    (moved,) = hertz.contacts([45], (0.5, -0.5))
    assert (moved.center_x, moved.center_y) == pytest.approx((20e-3, 8e-3))
    assert moved.phi == pytest.approx(np.pi / 4)


def test_cells_are_rounded_as_drawn() -> None:
    """Six digits, zero without a sign."""
    third = rounded({"a": np.array([1 / 3, np.nextafter(1 / 3, 1)]), "n": np.array([7, 8])})
    assert {name: column.tolist() for name, column in third.items()} == {"a": [0.333333] * 2, "n": [7, 8]}
    assert to_csv({"a": np.array([-0.0, 1 / 3]), "b": np.array(["x", "y"])}) == "a,b\n0,x\n0.333333,y\n"


# The command


def differing(one: Path, other: Path) -> set[str]:
    """Names of the files that are not equal."""
    names = {path.name for folder in (one, other) for path in folder.iterdir()}
    return {n for n in names if not (one / n).exists() or (one / n).read_bytes() != (other / n).read_bytes()}


@pytest.mark.long
def test_two_runs_write_the_same_bytes(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tfra.paper.report.REPEATS", 1)
    out = tmp_path / "again"
    monkeypatch.setenv("MPLCONFIGDIR", str(tmp_path))
    assert main(["paper", "--out", str(out), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert differing(folder, out) <= set(summary["not_reproducible"])
    assert summary == json.loads((folder / "paper.json").read_text())
    (out / "fig5.csv").write_text((out / "fig5.csv").read_text().replace("1", "2", 1))
    assert "fig5.csv" in differing(folder, out)


# The pages in a browser


@pytest.mark.parametrize(("name", "figures"), [*long(("index.html", 7)), ("fig9.html", 1)])
def test_page_loads(folder: Path, tmp_path: Path, name: str, figures: int) -> None:
    text = (folder / name).read_text()
    assert "<script" not in text
    assert not re.findall(r'(?:src|href)="(?!data:|#|https://doi\.org/|fig9\.html)', text)
    assert set(re.findall(r'href="#(\w+)"', text)) <= set(re.findall(r' id="(\w+)"', text))
    with browser(tmp_path) as tab:
        for width in (390, 600, 1280):
            tab.open(folder / name, width)
            assert tab.evaluate("document.documentElement.scrollWidth") == width
        widths = tab.evaluate("[...document.images].map(image => image.naturalWidth)")
        assert len(widths) == figures
        assert min(widths) > 300
        assert [*tab.messages, *faults_at_all_widths(tab)] == []
