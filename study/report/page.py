"""The report of a study: from tables to one interactive page that loads nothing."""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from itertools import product
from typing import Any

import plotly.graph_objects as go
import polars as pl
from plotly.offline import get_plotlyjs

from tfra.model.fixed.design import Design
from tfra.report import html
from tfra.report.html import contents, data_script, document, paragraph, text
from tfra.report.table import listed
from tfra.study.errors.cascade import View
from tfra.study.report import error_charts, signal_charts, trial_charts
from tfra.study.report.falls import fall_sentences
from tfra.study.report.labels import PARTS, QUANTITIES, STATISTICS, Tables, cell_text, column_label
from tfra.study.report.summary import cheapest_trials, costs_of, notes, summary

REFRESH_S = 10
"""Seconds after which an open partial page reloads."""

NOTES = {
    "flagged": "number of frames that each step flags",
    "decisions": "the arithmetic against float64 on the same codes, for frames whose earlier decisions agree",
    "baseline": "the same number of random trials",
}
"""Titles of tables without a chart."""


@dataclass(frozen=True)
class Chart:
    """A figure for each choice of the ``filters``; ``title`` tells it from another beside it."""

    name: str
    draw: Callable[..., go.Figure]
    filters: tuple[str, ...] = ()
    title: str = ""


@dataclass(frozen=True)
class Section:
    """Charts over ``tables``, which are under them; without the first table there is no section.

    ``caption`` explains how to read the charts; ``sentences`` are from the tables, for choices of the charts' filters.
    """

    name: str
    title: str
    caption: str
    tables: tuple[str, ...]
    charts: tuple[Chart, ...] = ()
    sentences: Callable[[Tables], Mapping[tuple[str, ...], str]] = lambda _: {}


def by_view(
    name: str, draw: Callable[..., go.Figure], filters: tuple[str, ...] = ("quantity", "statistic")
) -> tuple[Chart, ...]:
    """Return a chart of each view, beside each other where there is room."""
    return tuple(
        Chart(f"{name}-{view}", lambda *chosen, view=view: draw(*chosen, view), filters, title)
        for view, title in ((View.OWN, "Its own share"), (View.TOTAL, "Total error"))
    )


SECTIONS = (
    Section(
        "cascade",
        "Where the error comes from",
        "All steps process the same frames. A dot is the median of the error’s magnitude; the line ends at the 95th "
        "percentile. Blue is the change from the result of the step before; vermilion is the error against the ground "
        "truth after the step. A triangle at the left end is a median of zero.",
        ("errors", "flagged"),
        (Chart("cascade", error_charts.cascade, ("quantity", "part")),),
    ),
    Section(
        "estimators",
        "Estimators side by side",
        "The same frames, those that no step of any design flags. A dot is the median of the error’s magnitude; the "
        "line ends at the 95th percentile. Blue is the change from the step before; vermilion is the total.",
        ("estimators",),
        (Chart("estimators", error_charts.estimators, ("quantity",)),),
    ),
    Section(
        "flips",
        "Decisions that flip",
        "A dot is the share of frames in which a step decides differently from the step before. Its line is the 95 % "
        "confidence interval of the rate. A triangle at the left end means that no frame flipped.",
        ("flips", "decisions"),
        (Chart("flips", error_charts.flips, ("part",)),),
    ),
    Section(
        "ranges",
        "Ranges of all signals",
        "The pale bar is the word length; the blue bar has the bits that all observed values need; the difference is "
        "headroom. The black tick marks the bits that the proven bound needs. A cross marks words that saturated.",
        ("ranges",),
        (Chart("ranges", signal_charts.ranges),),
    ),
    Section(
        "lengths",
        "Magnitudes of coefficients and signals",
        "A row is a signal, or the coefficients of an operator; dark cells are the lengths that many of its words "
        "have, without the sign. The vermilion tick ends the word: cells that are empty below it are bits that nothing "
        "uses, and a row that ends far above zero rounds its small words away.",
        ("lengths",),
        (Chart("lengths", signal_charts.lengths),),
    ),
    Section(
        "stages",
        "Accuracy of each stage",
        "The ratio of a signal to its rounding error, 6 dB a bit: precision is lost at signals far to the left. "
        "Vermilion compares with float64 from the converter codes on, blue with float64 on the stage’s own inputs.",
        ("stages",),
        (Chart("stages", signal_charts.stages),),
    ),
    Section(
        "uniform",
        "How many bits",
        "All coefficients and operands have the same number of bits. The dashed line is the error without any "
        "arithmetic: where the total (vermilion) reaches it, more bits gain nothing. The dotted line is the method’s "
        "own error on exact stress.",
        ("uniform",),
        (Chart("uniform", error_charts.uniform, ("quantity", "statistic")),),
    ),
    Section(
        "converter",
        "Converter and noise",
        "A cell is the error after the converter, in the quantity’s unit; dark is large. Where a row stops changing to "
        "the right, only noise and method are left, and more bits of the converter gain nothing. A total smaller "
        "than the last of its row has its 95 % interval below. A cross marks impossible combinations, “few” those with "
        "too few frames.",
        ("converter",),
        by_view("converter", error_charts.converter),
        sentences=fall_sentences,
    ),
    Section(
        "sensitivity",
        "Which signals need their bits",
        "A bar is the growth of the error in percent when only this signal has fewer bits, worst on top. Signals "
        "without a bar have bits to spare. A click on the legend shows more bits less. A cross marks impossible "
        "combinations.",
        ("sensitivity",),
        by_view("sensitivity", error_charts.sensitivity),
    ),
    Section(
        "variants",
        "Other choices",
        "The same design with one choice changed. A dot is the median of the error’s magnitude; the line ends at the "
        "95th percentile. A cross marks impossible combinations.",
        ("variants",),
        by_view("variants", error_charts.variants, ("quantity",)),
    ),
    Section(
        "trials",
        "Cost of a smaller error",
        "A dot is a design that the search measured; lower left is better. The step line is the smallest error for a "
        "cost. Blue dots are Pareto-optimal in all objectives. Point at a dot for its word lengths. Costs are "
        "estimates; a thin line leads from a diamond or star to the cost after synthesis, or place and route.",
        ("trials", "baseline"),
        (Chart("trials", trial_charts.trials, ("cost",)),),
        sentences=cheapest_trials,
    ),
    Section(
        "designs",
        "Designs side by side",
        "A column is a design; the first is float arithmetic on the same codes. A design is within the tolerance if, "
        "on held-out frames, the 95th percentile of its total error exceeds that of float arithmetic by no more, in "
        "every quantity. Costs are estimates, except those synthesised or placed.",
        ("designs",),
    ),
)


def render(tables: Tables, design: Design, title: str, pending: Sequence[str] = ()) -> str:
    """The page of a study of ``design``; it depends only on the arguments.

    ``tables`` are those of a study's folder by name, any of which may be missing, and then has no section; ``pending``
    are the names of those that a running study has still to make.
    """
    tables = _complete(tables)
    return compose(SECTIONS, tables, title, summary(tables, design), notes(tables), pending)


def compose(
    every: Sequence[Section],
    tables: Tables,
    title: str,
    answer: Sequence[str],
    remarks: Sequence[str],
    pending: Sequence[str] = (),
) -> str:
    """A page of the sections that the ``tables`` have, below the lines of the ``answer`` and ``remarks`` on it."""
    sections = [section for section in every if section.tables[0] in tables]
    choices = _choices(tables)
    parts = [
        *_opening(every, tables, answer, remarks, pending),
        contents({section.name: section.title for section in sections}),
        _filters(sections, choices),
        *(_section(section, tables).html() for section in sections),
    ]
    if any(section.charts for section in sections):
        parts += [f"<script>{get_plotlyjs()}</script>", data_script("charts", _figures(sections, tables, choices))]
        parts.append(f"<script>{_resource('page.js')}</script>")
    policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    head += f'<meta http-equiv="refresh" content="{REFRESH_S}">' if pending else ""
    return document(title, parts, _resource("page.css"), head)


def _complete(tables: Tables) -> Tables:
    """The tables that have rows; that of sensitivities with the changes of the errors, without which it is left out."""
    complete = {name: table for name, table in tables.items() if len(table)}
    if (table := complete.pop("sensitivity", None)) is not None and "errors" in complete:
        complete["sensitivity"] = error_charts.with_change(table, complete["errors"])
    return complete


def _resource(name: str) -> str:
    return (files("tfra.study.report") / name).read_text(encoding="utf-8")


def _opening(
    every: Sequence[Section], tables: Tables, answer: Sequence[str], remarks: Sequence[str], pending: Sequence[str]
) -> Iterator[str]:
    if pending:
        titles = {table: f"{table} ({section.title})" for section in every for table in section.tables}
        missing = listed([titles.get(name, name) for name in pending])
        yield paragraph(f"This page is partial: the study is running. Still to come: {missing}.", "partial")
    if answer:
        yield f'<div class="answer">{"".join(map(paragraph, answer))}</div>'
    yield from (paragraph(sentence, "note") for sentence in remarks)
    if tables:
        yield "<noscript><p>The charts need JavaScript; their numbers are in the tables.</p></noscript>"


def _choices(tables: Tables) -> dict[str, dict[str, str]]:
    """The choices of each filter: values with their labels."""
    quantities, parts = (
        {value for table in tables.values() if column in table.columns for value in table[column]}
        for column in ("quantity", "part")
    )
    return {
        "quantity": {name: kind.axis for name, kind in QUANTITIES.items() if name in quantities},
        "statistic": dict(STATISTICS),
        "part": {str(part): name for part, name in PARTS.items() if part in parts},
        "cost": {name: column_label(name) for name in costs_of(tables)},
    }


def _filters(sections: Sequence[Section], choices: Mapping[str, Mapping[str, str]]) -> str:
    used = {name for section in sections for chart in section.charts for name in chart.filters}
    labels = {"quantity": "Error of", "statistic": "by its", "part": "Frames", "cost": "Cost"}
    selects = "".join(
        f'<label>{label} <select data-filter="{name}">{_options(choices[name])}</select></label>'
        for name, label in labels.items()
        if name in used
    )
    return f'<div class="filters">{selects}</div>' if selects else ""


def _options(choices: Mapping[str, str]) -> str:
    return "".join(f'<option value="{escape(value)}">{escape(label)}</option>' for value, label in choices.items())


def _figures(sections: Sequence[Section], tables: Tables, choices: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """All figures by chart and choice."""
    return {
        f"chart-{chart.name}": {
            "filters": chart.filters,
            "figures": {
                " ".join(chosen): json.loads(chart.draw(tables, *chosen).to_json())
                for chosen in product(*(choices[name] for name in chart.filters))
            },
        }
        for section in sections
        for chart in section.charts
    }


def _section(section: Section, tables: Tables) -> html.Section:
    parts = [paragraph(section.caption, "caption")]
    if section.charts:
        parts.append(f'<div class="charts">{"".join(map(_chart, section.charts))}</div>')
    for chosen, words in section.sentences(tables).items():
        data = dict(zip(section.charts[0].filters, chosen, strict=True))
        parts.append(f"<p{html.attributes(data)}>{text(words)}</p>")
    filters = {name for chart in section.charts for name in chart.filters}
    for name in section.tables:
        if name in tables:
            numbers = _turned(name, tables[name]) if name == "designs" else _grid(name, tables[name], filters)
            folded = f"<details><summary>{_caption(name)}</summary>{numbers}</details>"
            parts.append(folded if section.charts else numbers)
    return html.Section(section.name, section.title, parts)


def _caption(table: str) -> str:
    return f"Numbers: tables/{table}.parquet" + (f", {NOTES[table]}" if table in NOTES else "")


def _chart(chart: Chart) -> str:
    title = f"<figcaption>{escape(chart.title)}</figcaption>" if chart.title else ""
    return f'<figure>{title}<div id="chart-{chart.name}"></div></figure>'


def _turned(name: str, table: pl.DataFrame) -> str:
    """A table of few rows with many columns: a column for each of its rows, under the first cell of each."""
    first, *others = table.columns
    rows = (html.row([column_label(each), *(cell_text(each, value) for value in table[each])], {0}) for each in others)
    return html.grid(_caption(name), [column_label(first), *table[first]], [rows], {0}, table=name)


def _grid(name: str, table: pl.DataFrame, filters: Collection[str]) -> str:
    """A table with all its rows; those of another choice than that of the ``filters`` are hidden when looked at."""
    words = {number for number, kind in enumerate(table.dtypes) if kind == pl.String}
    filtered = [column for column in table.columns if column in filters]
    rows = (
        html.row([cell_text(*item) for item in cells.items()], words, **{column: cells[column] for column in filtered})
        for cells in table.iter_rows(named=True)
    )
    return html.grid(_caption(name), list(map(column_label, table.columns)), [rows], words, table=name)
