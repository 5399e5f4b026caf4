"""The report in a browser and beside its tables."""

import html
import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from tests.accessibility import faults_at_all_widths
from tests.browser import Browser, browser
from tests.marks import long
from tests.study.definitions import definition, design
from tests.study.report_tables import FORCE, make
from tfra.study.report.labels import QUANTITIES
from tfra.study.report.page import SECTIONS, render
from tfra.study.report.summary import HEADLINE

CHARTS = [f"chart-{chart.name}" for section in SECTIONS for chart in section.charts]
TITLE = "A 6×8 sensor"

WIDEST = """(() => {
  const marks = document.querySelectorAll('#CHART .cartesianlayer :is(.points path, .heatmaplayer image)');
  if (!marks.length) return null;
  const widths = [...marks].map(mark => mark.getBoundingClientRect().width);
  const widest = marks[widths.indexOf(Math.max(...widths))];
  widest.scrollIntoView({block: 'center'});
  const box = widest.getBoundingClientRect();
  return [box.x + box.width / 2, box.y + box.height / 2];
})()"""
"""The middle of the widest dot, bar or map of a chart, in the window; null where nothing is drawn."""

FITS = """[...document.querySelectorAll('.js-plotly-plot')].every(
  chart => chart.querySelector('svg').clientWidth == chart.clientWidth)"""

CUT_OFF = """[...document.querySelectorAll('.js-plotly-plot')].flatMap(chart => {
  const frame = chart.getBoundingClientRect();
  return [...chart.querySelectorAll('.xtick text, .ytick text, .xtitle, .ytitle, .legendtext')].filter(label => {
    const box = label.getBoundingClientRect();
    return box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1
      || box.bottom > frame.bottom + 1;
  }).map(label => chart.id + ': ' + label.textContent);
})"""
"""Labels that reach over the edge of their chart."""

AGAIN = """
import sys, polars as pl
from pathlib import Path
from tests.study.definitions import design
from tfra.study.report.page import render
tables = {file.stem: pl.read_parquet(file) for file in sorted(Path(sys.argv[1]).glob("*.parquet"), reverse=True)}
sys.stdout.buffer.write(render(tables, design(), sys.argv[2]).encode())
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tables of a small study."""
    folder = tmp_path_factory.mktemp("study")
    made = make(design(), definition(train=420, held_out=420), folder)
    for name, table in made.items():
        table.write_parquet(folder / f"{name}.parquet")
    return folder


@pytest.fixture(scope="module")
def tables(folder: Path) -> dict[str, pl.DataFrame]:
    return {file.stem: pl.read_parquet(file) for file in sorted(folder.glob("*.parquet"))}


@pytest.fixture(scope="module")
def page(tables: dict[str, pl.DataFrame]) -> str:
    return render(tables, design(), TITLE)


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("browser")) as tab:
        yield tab


@pytest.fixture(scope="module")
def shown(tab: Browser, page: str, folder: Path) -> Browser:
    """The browser with the page in it; tests that need another one come behind."""
    show(tab, folder, page)
    return tab


def show(tab: Browser, folder: Path, text: str) -> None:
    """Load the page ``text``."""
    file = folder / "page.html"
    file.write_text(text, encoding="utf-8")
    tab.open(file)


def grids(text: str) -> dict[str, list[list[str]]]:
    """Cells of the bodies of all tables of a page."""
    found = {}
    for name, body in re.findall(r'<table data-table="(\w+)">.*?</thead>(.*?)</table>', text, re.S):
        lines = re.findall(r"<tr[^>]*>(.*?)</tr>", body, re.S)
        found[name] = [[html.unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", line)] for line in lines]
    return found


def figures(text: str) -> dict[str, dict[str, Any]]:
    """All figures of a page by chart and choice."""
    (content,) = re.findall(r'<script type="application/json" id="charts">(.*?)</script>', text, re.S)
    return {name: chart["figures"] for name, chart in json.loads(content).items()}


def traces(text: str, chart: str, *chosen: str) -> dict[str, dict[str, Any]]:
    """What a figure draws, by its name in the legend."""
    data = figures(text)[f"chart-{chart}"][" ".join(chosen)]["data"]
    return {trace["name"]: trace for trace in data if "name" in trace and trace.get("showlegend", True)}


# In a browser


def test_every_chart_is_drawn_and_answers(shown: Browser) -> None:
    tab = shown
    assert tab.evaluate("[...document.querySelectorAll('.js-plotly-plot')].map(chart => chart.id)") == CHARTS
    for chart in CHARTS:
        box = tab.evaluate(WIDEST.replace("CHART", chart))
        assert box, chart
        tab.point(*box)
        label = tab.until(f"document.querySelector('#{chart} .hoverlayer .hovertext')?.textContent")
        assert re.search(r"\d", label), chart
    assert tab.messages == []
    assert tab.requests == []


@pytest.mark.long
def test_accessibility(shown: Browser) -> None:
    shown.until("document.querySelector('.js-plotly-plot svg')")
    assert faults_at_all_widths(shown) == []


def test_filters_change_the_charts_and_the_tables(shown: Browser, page: str) -> None:
    tab = shown
    choose = "{0}.value = {1!r}; {0}.dispatchEvent(new Event('change'))"
    sentences = "[...document.querySelectorAll('p[data-cost]')].filter(p => !p.hidden).map(p => p.dataset.cost)"
    rows = "[...document.querySelectorAll('[data-table=uniform] tbody tr')].filter(row => !row.hidden)"
    filters = tab.evaluate(
        "[...document.querySelectorAll('select')].map(s => [s.dataset.filter, [...s.options].map(o => o.value)])"
    )
    assert [name for name, _ in filters] == ["quantity", "statistic", "part", "cost"]
    for name, values in filters:
        for value in reversed(values):
            tab.evaluate(choose.format(f"document.querySelector('[data-filter={name}]')", value))
            if name == "cost":
                assert tab.evaluate(sentences) == [value]
            if name == "quantity":
                assert tab.evaluate(f"{rows}.map(row => row.dataset.quantity)") == [value] * 10
                drawn = tab.evaluate("document.getElementById('chart-uniform').data[0].y")
                assert drawn == traces(page, "uniform", value, "p95")["arithmetic alone"]["y"]
    assert tab.evaluate(CUT_OFF) == []
    assert tab.messages == []


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_is_wider_than_the_window(shown: Browser, width: int) -> None:
    tab = shown
    tab.resize(width)
    tab.until(FITS)
    tab.evaluate("document.querySelectorAll('details').forEach(details => details.open = true)")
    assert tab.evaluate("innerWidth") == width
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.evaluate(CUT_OFF) == []


def test_nothing_sends_a_chart_anywhere(shown: Browser) -> None:
    shown.resize(1280)
    buttons = shown.evaluate("[...document.querySelectorAll('.modebar-btn')].map(button => button.dataset.title)")
    assert set(buttons) == {"Zoom", "Pan", "Reset axes", "Download plot as a PNG"}


def test_looking_finds_a_broken_page(tab: Browser, tmp_path: Path) -> None:
    broken = "<script>fetch('http://localhost:9/'); console.error('broken')</script></body>"
    page = render({}, design(), TITLE).replace("</body>", broken)
    show(tab, tmp_path, page)
    assert any("Content Security Policy" in message for message in tab.messages)
    assert "broken" in tab.messages
    show(tab, tmp_path, re.sub("<meta http-equiv[^>]*>", "", page))
    assert tab.requests == ["http://localhost:9/"]


# Beside the tables


def compare(text: str, tables: dict[str, pl.DataFrame]) -> None:
    """Raise ``AssertionError`` unless every number of the tables stands in the page, to six digits."""
    shown = grids(text)
    assert set(shown) == set(tables)
    for name, table in tables.items():
        rows = shown[name]
        if name == "designs":  # stand in columns, under their names
            rows = [[design, *cells] for design, *cells in zip(table["name"], *(row[1:] for row in rows), strict=True)]
        for cells, row in zip(rows, table.iter_rows(), strict=True):
            # That of sensitivities has the changes behind.
            for column, cell, value in zip(table.columns, cells, row, strict=False):
                if isinstance(value, bool):
                    assert cell == ("yes" if value else "no")
                elif isinstance(value, int | float):
                    assert float(cell.replace(",", "")) == pytest.approx(value, rel=1e-5), (name, row)
                elif column == "quantity":
                    assert cell == QUANTITIES[value].axis
                else:
                    assert cell == ("–" if value is None else value)


def test_tables_of_the_page_are_those_of_the_study(page: str, tables: dict[str, pl.DataFrame]) -> None:
    compare(page, tables)
    worst = f"{tables['errors']['worst'][3]:.6g}"
    with pytest.raises(AssertionError):
        compare(page.replace(f"<td>{worst}</td>", f"<td>1{worst}</td>"), tables)


def test_figures_show_what_the_tables_say(page: str, tables: dict[str, pl.DataFrame]) -> None:
    errors = tables["errors"].filter(part="held_out", quantity="mu")
    for view, name in (("own", "its own share"), ("total", "total")):
        shown = traces(page, "cascade", "mu", "held_out")[name]
        assert shown["x"] == errors.filter(view=view)["median"].to_list()
    own = tables["uniform"].filter(pl.col("reason").is_null(), quantity="phi_deg", view="own")
    line = traces(page, "uniform", "phi_deg", "p95")["arithmetic alone"]
    assert (line["x"], line["y"]) == (own["bits"].to_list(), own["p95"].to_list())
    floor = tables["errors"].filter(part="train", quantity="phi_deg", step="method", view="total")["p95"].item()
    assert traces(page, "uniform", "phi_deg", "p95")["the method itself"]["y"] == [floor, floor]
    ranges = traces(page, "ranges")
    assert ranges["word"]["x"] == tables["ranges"]["bits"].to_list()
    assert ranges["needed for what was seen"]["x"] == tables["ranges"]["bits_needed"].to_list()
    stages = tables["stages"].filter(reference="inputs", exact=False)
    assert traces(page, "stages")["this stage alone"]["x"] == stages["sqnr_db"].to_list()


def test_flips_and_heat_maps_show_what_the_tables_say(page: str, tables: dict[str, pl.DataFrame]) -> None:
    flips = tables["flips"].filter(part="train", step="noise", decision="quadrant")["rate"].item()
    assert flips in traces(page, "flips", "train")["noise and offset"]["x"]
    cells = tables["converter"].filter(quantity=FORCE, step="converter", view="own")
    figure = figures(page)["chart-converter-own"][f"{FORCE} p95"]
    (shown,) = figure["data"]
    found = {
        (noise, bits): text
        for noise, line in zip(shown["y"], shown["text"], strict=True)
        for bits, text in zip(shown["x"], line, strict=True)
    }
    assert len(found) == len(cells)
    for row in cells.iter_rows(named=True):
        text = found[f"{100 * row['noise_share_of_peak']:g}", str(row["bits"])]
        assert float(text.partition("<br>")[0] or "nan") == pytest.approx(row["p95"] or math.nan, rel=0.06, nan_ok=True)
    assert any(found.values())
    assert [note["x"] for note in figure["layout"]["annotations"] if note["text"] == "×"] == ["16", "16"]
    axes = figure["layout"]["xaxis"], figure["layout"]["yaxis"]
    assert [axis["tickvals"] for axis in axes] == [axis["ticktext"] for axis in axes]


def test_what_does_not_fit_is_a_cross_with_its_reason(page: str, tables: dict[str, pl.DataFrame]) -> None:
    crosses = traces(page, "uniform", "mu", "p95")["does not fit"]
    (reason,) = tables["uniform"].filter(bits=28)["reason"].unique()
    assert (crosses["x"], len(crosses["y"])) == ([28], 1)
    assert crosses["hovertext"][0].replace("<br>", " ").endswith(f"reason: {reason}")
    data = figures(page)["chart-sensitivity-own"]["mu p95"]["data"]
    texts = [trace["hovertext"][0] for trace in data if trace["type"] == "scatter"]
    for text, shorter in zip(texts, (1, 4), strict=True):
        assert f"<br>signal: cordic; bits: {18 - shorter}; shorter: {shorter}; " in text


def test_sensitivity_is_relative_to_the_design_as_it_is(page: str, tables: dict[str, pl.DataFrame]) -> None:
    own = {"quantity": FORCE, "step": "arithmetic", "view": "own"}
    base = tables["errors"].filter(part="train", **own)["p95"].item()
    shown = traces(page, "sensitivity-own", FORCE, "p95")["1 bit less"]
    labels = figures(page)["chart-sensitivity-own"][f"{FORCE} p95"]["layout"]["yaxis"]["ticktext"]
    for place, value in zip(shown["y"], shown["x"], strict=True):
        row = tables["sensitivity"].filter(signal=labels[place], shorter=1, **own)
        assert value == pytest.approx(100 * (row["p95"].item() / base - 1))


def test_the_fewest_bits_less_are_shown_first(tables: dict[str, pl.DataFrame]) -> None:
    """Which are not one bit in every study."""
    some = {"errors": tables["errors"], "sensitivity": tables["sensitivity"].filter(shorter=4)}
    shown = traces(render(some, design(), TITLE), "sensitivity-own", FORCE, "p95")
    assert list(shown) == ["4 bits less"]
    assert shown["4 bits less"]["visible"] is True
    assert shown["4 bits less"]["x"]


# Bytes, and what is missing


@pytest.mark.long
def test_the_same_bytes_in_another_process(page: str, folder: Path) -> None:
    command = [sys.executable, "-c", AGAIN, str(folder), TITLE]
    other = subprocess.run(command, capture_output=True, check=True, env=os.environ | {"PYTHONHASHSEED": "7"})
    assert other.stdout.decode() == page


@pytest.mark.parametrize("missing", ["errors", *long("flagged", "trials", "designs")])
def test_without_a_table_there_is_no_section(tables: dict[str, pl.DataFrame], missing: str) -> None:
    some = {name: headline(table) for name, table in tables.items() if name != missing}
    text = render(some, design(), TITLE)
    gone = {section.name for section in SECTIONS if section.tables[0] == missing}
    gone |= {"sensitivity"} if missing == "errors" else set()
    headings = set(re.findall(r'<h2 id="(\w+)">', text))
    assert headings == {section.name for section in SECTIONS} - gone
    assert headings == set(re.findall(r'<a href="#(\w+)">', text))
    for body in re.findall(r"<section>(.*?)</section>", text, re.S):
        assert "<table" in body
    assert set(figures(text)) == {f"chart-{c.name}" for s in SECTIONS if s.name in headings for c in s.charts}


def headline(table: pl.DataFrame) -> pl.DataFrame:
    """The rows of the first two quantities, where rows have one."""
    return table.filter(pl.col("quantity").is_in(list(HEADLINE))) if "quantity" in table.columns else table


def test_a_page_of_nothing(tab: Browser, tmp_path: Path) -> None:
    text = render({"errors": pl.DataFrame()}, design(), TITLE, pending=["errors", "trials"])
    assert "Still to come: errors (Where the error comes from) and trials (Cost of a smaller error)." in text
    assert not re.search("<h2|<nav|<select", text)
    show(tab, tmp_path, text)
    assert tab.messages == []


def test_an_open_page_follows_the_run_and_keeps_what_was_chosen(
    tab: Browser, tables: dict[str, pl.DataFrame], page: str, tmp_path: Path
) -> None:
    some = {name: tables[name] for name in ("errors", "uniform")}
    text = render(some, design(), TITLE, pending=["trials"])
    refresh = '<meta http-equiv="refresh" content="10">'
    assert refresh in text
    assert refresh not in page
    select = "document.querySelector('[data-filter=quantity]')"
    show(tab, tmp_path, text)
    tab.evaluate(f"{select}.value = 'mu'; {select}.dispatchEvent(new Event('change'))")
    show(tab, tmp_path, text)
    assert tab.evaluate(f"{select}.value") == "mu"
    assert "error of μ" in tab.evaluate("document.getElementById('chart-cascade').textContent")
    few = {name: headline(table) for name, table in some.items()}
    show(tab, tmp_path, render(few, design(), TITLE, pending=["trials"]))
    assert tab.evaluate(f"{select}.value") == FORCE
    assert tab.messages == []
    tab.evaluate("sessionStorage.clear()")


@pytest.mark.long
def test_few_frames_and_hostile_words(tab: Browser, tables: dict[str, pl.DataFrame], tmp_path: Path) -> None:
    """Percentiles of few frames are null; names are never markup."""
    null = [pl.lit(None, dtype=pl.Float64).alias(name) for name in ("median", "p95", "p99_9")]
    none = [pl.lit(None).alias(name) for name in (FORCE, "phi_deg", "coefficient_kbit", "latency_cycles")]
    some = {name: table.with_columns(null) if "p95" in table.columns else table for name, table in tables.items()}
    evil = "</script><script>console.error('evil')</script><img src=x onerror=console.error('evil')>"
    some["trials"] = some["trials"].with_columns(*none, state=pl.lit("unfit"), front=False)
    for name, column in (("trials", "reason"), ("designs", "name"), ("ranges", "signal")):
        some[name] = some[name].with_columns(pl.lit(evil).alias(column))
    text = render(some, design(), evil, pending=[evil])
    shown = {name: list(each.values()) for name, each in figures(text).items()}
    for name in ("cascade", "uniform", "sensitivity-total", "variants-own"):
        assert all('"too few frames"' in json.dumps(figure) for figure in shown[f"chart-{name}"])
    notes = [note["text"] for note in shown["chart-converter-own"][0]["layout"]["annotations"]]
    assert notes == ["few", "few", "×"] * 2
    assert '"no trial is complete"' in json.dumps(shown["chart-trials"][0])
    assert "Limit: there are too few frames to split the error into steps." in text
    show(tab, tmp_path, text)
    assert tab.messages == []
    assert tab.requests == []
