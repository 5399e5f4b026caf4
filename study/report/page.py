"""The report of a study: from tables to one interactive page that loads nothing."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from importlib.resources import files
from itertools import product
from typing import Any

import plotly.graph_objects as go
import polars as pl
from plotly.offline import get_plotlyjs

from tfra.model.fixed.design import Design
from tfra.report.html import contents, document, grid, row
from tfra.study.errors.cascade import View
from tfra.study.report import charts, front
from tfra.study.report.answer import answer, explanation, unfit
from tfra.study.report.found import compared, costs_of
from tfra.study.report.words import CLOSE, PARTS, QUANTITIES, STATISTICS, Tables, listed

HEADINGS = {
    "p95": "95th percentile",
    "p99_9": "99.9th percentile",
    "p95_change": "change of the 95th percentile / %",
    "median_change": "change of the median / %",
    "of": "of frames",
    "rate_low": "95 % confidence, from",
    "rate_high": "to",
    "sqnr_db": "SQNR / dB",
    "max_error_lsb": "worst / LSB",
    "rms_error_lsb": "rms / LSB",
    "bias_lsb": "bias / LSB",
    "noise_share_of_peak": "noise, share of the peak",
    "plateau_tolerance_lsb": "plateau tolerance / LSB",
    "sweep_index_equal": "share of frames with float’s sweep index",
    "within": f"within {CLOSE} of float’s total",
    "rtl_frames": "frames in RTL",
    "rtl_words": "words in RTL",
    "rtl_differ": "words that differ",
}
"""Headings of the columns of tables; other columns keep their names."""

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
    """Charts over the tables ``shown``, which stand under them; without the first there is no section.

    ``caption`` says how they are read; ``view`` prepares a table to be shown; ``said`` is a sentence from the tables,
    ``by_cost`` one for each choice of a cost.
    """

    name: str
    title: str
    caption: str
    shown: tuple[str, ...]
    charts: tuple[Chart, ...] = ()
    needs: tuple[str, ...] = ()
    view: Callable[[Tables], pl.DataFrame] | None = None
    said: Callable[[Tables], str] = lambda _: ""
    by_cost: Callable[[Tables], Mapping[str, str]] = lambda _: {}


OF_ARITHMETIC = {View.OWN: "Error of the arithmetic", View.TOTAL: "Total error"}


def _by_view(
    name: str,
    draw: Callable[..., go.Figure],
    titles: Mapping[View, str],
    filters: tuple[str, ...] = ("quantity", "statistic"),
) -> tuple[Chart, ...]:
    """A chart of each view, beside each other where there is room."""
    return tuple(
        Chart(f"{name}-{view}", lambda *given, view=view: draw(*given, view), filters, title)
        for view, title in titles.items()
    )


SECTIONS = (
    Section(
        "cascade",
        "Where the error comes from",
        "All steps process the same frames. A dot is the median of the error’s magnitude; the line ends at the 95th "
        "percentile. Blue is the change from the result of the step before; vermilion is the error against the ground "
        "truth after the step. A triangle at the left end is a median of zero.",
        ("errors", "flagged"),
        (Chart("cascade", charts.cascade, ("quantity", "part")),),
    ),
    Section(
        "flips",
        "Decisions that flip",
        "A dot is the share of frames in which a step decides differently from the step before. Its line is the 95 % "
        "confidence interval of the rate. A triangle at the left end means that no frame flipped.",
        ("flips", "decisions"),
        (Chart("flips", charts.flips, ("part",)),),
    ),
    Section(
        "ranges",
        "Ranges of all signals",
        "The pale bar is the word length; the blue bar has the bits that all observed values need; the difference is "
        "headroom. The black tick marks the bits that the proven bound needs. A cross marks words that saturated.",
        ("ranges",),
        (Chart("ranges", charts.ranges),),
    ),
    Section(
        "stages",
        "Accuracy of each stage",
        "The ratio of a signal to its rounding error, 6 dB a bit: precision is lost at signals far to the left. "
        "Vermilion compares with float64 from the converter codes on, blue with float64 on the stage’s own inputs.",
        ("stages",),
        (Chart("stages", charts.stages),),
    ),
    Section(
        "uniform",
        "How many bits",
        "All coefficients and operands have the same number of bits. The dashed line is the error without any "
        "arithmetic: where the total (vermilion) reaches it, more bits gain nothing. The dotted line is the method’s "
        "own error on exact stress.",
        ("uniform",),
        (Chart("uniform", charts.uniform, ("quantity", "statistic")),),
        said=partial(unfit, name="uniform"),
    ),
    Section(
        "converter",
        "Converter and noise",
        "A cell is the error after the converter, in the quantity’s unit; dark is large. Where a row stops changing to "
        "the right, only noise and method are left, and more bits of the converter gain nothing. A cross marks "
        "impossible combinations, “few” those with too few frames.",
        ("converter",),
        _by_view("converter", charts.converter, {View.TOTAL: "Total error", View.OWN: "The converter’s own share"}),
        said=partial(unfit, name="converter"),
    ),
    Section(
        "sensitivity",
        "Which signals need their bits",
        "A bar is the growth of the error in percent when only this signal has one bit less, worst on top. Signals "
        "without a bar have bits to spare. A click on the legend shows two and four bits less. A cross marks "
        "impossible combinations.",
        ("sensitivity",),
        _by_view("sensitivity", charts.sensitivity, OF_ARITHMETIC),
        needs=("errors",),
        view=charts.with_change,
        said=partial(unfit, name="sensitivity"),
    ),
    Section(
        "variants",
        "Other choices",
        "The same design with one choice changed. A dot is the median of the error’s magnitude; the line ends at the "
        "95th percentile. A cross marks impossible combinations.",
        ("variants",),
        _by_view("variants", charts.variants, OF_ARITHMETIC, ("quantity",)),
        said=partial(unfit, name="variants"),
    ),
    Section(
        "trials",
        "Cost of a smaller error",
        "A dot is a design that the search measured; lower left is better. The step line is the smallest error for a "
        "cost. Blue dots are Pareto-optimal in all objectives. Point at a dot for its word lengths. Costs are "
        "estimates; a thin line leads from a star to the cost measured after place and route.",
        ("trials", "baseline"),
        (Chart("trials", front.trials, ("cost",)),),
        by_cost=compared,
    ),
    Section(
        "designs",
        "Designs side by side",
        "A row is a design; the first is float arithmetic on the same codes. Costs are estimates, except placed ones.",
        ("designs",),
    ),
)


def render(tables: Tables, design: Design, title: str, pending: Sequence[str] = ()) -> str:
    """The page of a study of ``design``; it depends only on the arguments.

    ``tables`` are those of a study's folder by name, any of which may be missing, and then has no section; ``pending``
    are the names of those that a running study has still to make.
    """
    tables = {name: table for name, table in tables.items() if len(table)}
    sections = [s for s in SECTIONS if s.shown[0] in tables and all(name in tables for name in s.needs)]
    choices = _choices(tables)
    parts = [
        *_words(tables, design, pending),
        contents({section.name: section.title for section in sections}),
        _filters(sections, choices),
        *(_section(section, tables) for section in sections),
        *(_scripts(sections, tables, choices) if any(section.charts for section in sections) else ()),
    ]
    policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    head += f'<meta http-equiv="refresh" content="{REFRESH_S}">' if pending else ""
    return document(title, parts, _resource("page.css"), head)


def _resource(name: str) -> str:
    return (files("tfra.study.report") / name).read_text(encoding="utf-8")


def _words(tables: Tables, design: Design, pending: Sequence[str]) -> Iterator[str]:
    if pending:
        missing = listed([_title_of(name) for name in pending])
        yield f'<p class="partial">This page is partial: the study is running. Still to come: {escape(missing)}.</p>'
    said = answer(tables, design)
    if said:
        yield f'<p class="answer">{_inline(said)}</p>'
    yield from (f'<p class="note">{_inline(sentence)}</p>' for sentence in explanation(tables))
    if tables:
        yield "<noscript><p>The charts need JavaScript; their numbers are in the tables.</p></noscript>"


def _title_of(table: str) -> str:
    titles = [section.title for section in SECTIONS if table in section.shown]
    return f"{table} ({titles[0]})" if titles else table


def _inline(text: str) -> str:
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))


def _choices(tables: Tables) -> dict[str, dict[str, str]]:
    """What each filter offers: values with their labels."""
    of_errors = [table for table in tables.values() if "quantity" in table.columns]
    there = {quantity for table in of_errors for quantity in table["quantity"]}
    parts = {part for table in tables.values() if "part" in table.columns for part in table["part"]}
    costs = costs_of(tables["trials"]) if "trials" in tables else []
    return {
        "quantity": {name: kind.axis for name, kind in QUANTITIES.items() if name in there},
        "statistic": dict(STATISTICS),
        "part": {str(part): name for part, name in PARTS.items() if part in parts},
        "cost": {name: front.title(name) for name in costs},
    }


def _filters(sections: Sequence[Section], choices: Mapping[str, Mapping[str, str]]) -> str:
    used = {name for section in sections for chart in section.charts for name in chart.filters}
    named = {"quantity": "Error of", "statistic": "by its", "part": "Frames", "cost": "Cost"}
    selects = "".join(
        f'<label>{label} <select data-filter="{name}">{_options(choices[name])}</select></label>'
        for name, label in named.items()
        if name in used
    )
    return f'<div class="filters">{selects}</div>' if selects else ""


def _options(offered: Mapping[str, str]) -> str:
    return "".join(f'<option value="{escape(value)}">{escape(label)}</option>' for value, label in offered.items())


def _scripts(sections: Sequence[Section], tables: Tables, choices: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    yield f"<script>{get_plotlyjs()}</script>"
    yield f'<script type="application/json" id="charts">{_figures(sections, tables, choices)}</script>'
    yield f"<script>{_resource('page.js')}</script>"


def _figures(sections: Sequence[Section], tables: Tables, choices: Mapping[str, Mapping[str, str]]) -> str:
    """JSON of all figures by chart and choice; no text in it can end the script around it."""
    drawn = {
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
    return json.dumps(drawn, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _section(section: Section, tables: Tables) -> str:
    heading = f'<h2 id="{section.name}">{escape(section.title)}</h2><p class="caption">{escape(section.caption)}</p>'
    said = section.said(tables)
    heading += f'<p class="note">{_inline(said)}</p>' if said else ""
    shown = {name: tables[name] for name in section.shown if name in tables}
    if section.view:
        shown[section.shown[0]] = section.view(tables)
    followed = {name for chart in section.charts for name in chart.filters}
    numbers = {name: _grid(name, frame, followed) for name, frame in shown.items()}
    if not section.charts:
        return f"<section>{heading}{''.join(numbers.values())}</section>"
    drawn = f'<div class="charts">{"".join(map(_chart, section.charts))}</div>'
    below = (f'<p data-cost="{cost}">{_inline(said)}</p>' for cost, said in section.by_cost(tables).items())
    folded = (f"<details><summary>{_summary(name)}</summary>{shown}</details>" for name, shown in numbers.items())
    return f"<section>{heading}{drawn}{''.join((*below, *folded))}</section>"


def _summary(table: str) -> str:
    return f"Numbers: tables/{table}.parquet" + (f", {NOTES[table]}" if table in NOTES else "")


def _chart(chart: Chart) -> str:
    title = f"<figcaption>{escape(chart.title)}</figcaption>" if chart.title else ""
    return f'<figure>{title}<div id="chart-{chart.name}"></div></figure>'


def _grid(name: str, table: pl.DataFrame, filters: Collection[str]) -> str:
    """A table with all its rows; those of another choice than that of the ``filters`` are hidden when looked at."""
    header = [HEADINGS.get(column, front.title(column)) for column in table.columns]
    texts = {place for place, kind in enumerate(table.dtypes) if kind == pl.String}
    followed = [column for column in table.columns if column in filters]
    rows = (
        row([_cell(column, value) for column, value in found.items()], texts, **{key: found[key] for key in followed})
        for found in table.iter_rows(named=True)
    )
    return grid(_summary(name), header, [rows], texts, table=name)


def _cell(column: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if column == "quantity":
        return QUANTITIES[value].axis
    return f"{value:,}" if isinstance(value, int) else str(value)
