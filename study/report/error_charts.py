"""A function for each chart of errors: from tables to a figure, whose numbers are those of the tables.

Arithmetic alone is blue, totals are vermilion; series that differ in colour also differ in shape or dash.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import plotly.graph_objects as go
import polars as pl
from polars import selectors as cs

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from tfra.report.table import number
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import INTERVAL
from tfra.study.frames.block import Part
from tfra.study.report.falls import falls
from tfra.study.report.figure import (
    GREY,
    ROW_HEIGHT,
    Row,
    Scale,
    Style,
    add_dots,
    add_marks,
    add_misfits,
    figure,
    grouped,
    hover_text,
    interval,
    is_misfit,
    rows_figure,
    series,
    ticks,
    unless_empty,
)
from tfra.study.report.labels import QUANTITIES, STATISTICS, STEPS, VARIANTS, Tables, setting

VIEWS = {View.OWN: Style("its own share", BLUE, "circle"), View.TOTAL: Style("total", VERMILION, "diamond")}

FLIPS = {
    "status": "status flags",
    "quadrant": "quadrant of φ",
    "swept_variable": "swept variable",
    "sweep_index_off_by_one": "index off by one",
    "sweep_index_off_by_more": "index off by more",
}
"""Decisions whose rate is that of a change, and their labels."""

_FLIPPING = {
    Step.NOISE: Style(STEPS[Step.NOISE], PURPLE, "square"),
    Step.CONVERTER: Style(STEPS[Step.CONVERTER], GREEN, "diamond"),
    Step.ARITHMETIC: Style(STEPS[Step.ARITHMETIC], BLUE, "circle"),
}


def cascade(tables: Tables, quantity: str, part: str) -> go.Figure:
    """Median and 95th percentile of each step's own share and of the total after it."""
    rows = tables["errors"].filter(quantity=quantity, part=part).to_dicts()
    steps = list(Step)
    points = [(steps.index(row["step"]), row) for row in rows]
    return _errors(points, [STEPS[step] for step in steps], 62, quantity)


def estimators(tables: Tables, quantity: str) -> go.Figure:
    """The steps of every design, one design below the other."""
    rows = tables["estimators"].filter(quantity=quantity).to_dicts()
    names = list(dict.fromkeys((row["design"], row["estimator"]) for row in rows))
    groups = [f"{design} ({estimator})" for design, estimator in names for _ in Step]
    labels, positions = grouped(groups, [STEPS[step] for _ in names for step in Step])
    places = [(design, step) for design, _ in names for step in Step]
    at = dict(zip(places, positions, strict=True))
    return _errors([(at[row["design"], row["step"]], row) for row in rows], labels, 40, quantity)


def variants(tables: Tables, quantity: str, view: str) -> go.Figure:
    """One view of the arithmetic's errors, for each variant of the design."""
    rows = tables["variants"].filter(quantity=quantity, step=Step.ARITHMETIC, view=view).to_dicts()
    settings = [(row["variant"], row[VARIANTS[row["variant"]][0]]) for row in rows]
    distinct = list(dict.fromkeys(settings))
    labels, positions = grouped([VARIANTS[name][1] for name, _ in distinct], [setting(value) for _, value in distinct])
    at = dict(zip(distinct, positions, strict=True))
    return _errors([(at[each], row) for each, row in zip(settings, rows, strict=True)], labels, 24, quantity)


def flips(tables: Tables, part: str) -> go.Figure:
    """How often each step's decision differs from that of the step before, with its interval."""
    rows = tables["flips"].filter(pl.col("decision").is_in(list(FLIPS)), part=part).to_dicts()
    made = [decision for decision in FLIPS if any(row["decision"] == decision for row in rows)]
    points, labels = [(made.index(row["decision"]), row) for row in rows], [FLIPS[decision] for decision in made]
    columns = ("rate", "rate_low", "rate_high")
    return dots(points, labels, 54, "share of frames that flip", columns, "step", _FLIPPING)


def _errors(points: Sequence[tuple[int, Row]], labels: Sequence[str], height: int, quantity: str) -> go.Figure:
    title = f"error of {QUANTITIES[quantity].axis}"
    return dots(points, labels, height, title, ("median", "median", "p95"), "view", VIEWS)


def dots(
    points: Sequence[tuple[int, Row]],
    labels: Sequence[str],
    height: int,
    title: str,
    columns: tuple[str, str, str],
    key: str,
    styles: Mapping[Any, Style],
) -> go.Figure:
    """Draw every row of ``points`` in its labelled row, as one of the series by its ``key``, beside each other.

    ``columns`` are those of the value and of its whisker's ends.
    """
    known = [(position, row) for position, row in points if row[columns[0]] is not None]
    scale = Scale.of(row[name] for _, row in known for name in columns)
    chart = rows_figure(labels, height, scale.axis(title))
    drawn = [each for each in styles if any(row[key] == each for _, row in known)]
    for n, each in enumerate(drawn):
        offset = 0.27 * (n - (len(drawn) - 1) / 2)
        add_dots(chart, scale, styles[each], [(at + offset, row) for at, row in known if row[key] == each], *columns)
    misfits = [(position, row) for position, row in points if is_misfit(row)]
    add_misfits(chart, [row for _, row in misfits], [scale.low] * len(misfits), [position for position, _ in misfits])
    return unless_empty(chart, bool(known), "too few frames")


def uniform(tables: Tables, quantity: str, statistic: str) -> go.Figure:
    """Error against the bits of uniform designs, with what is left without arithmetic, and with the method alone."""
    rows = tables["uniform"].filter(quantity=quantity, step=Step.ARITHMETIC).sort("bits").to_dicts()
    limits = _limits(tables, quantity, statistic)
    scale = Scale.of(row[statistic] for row in [*rows, *(limit for *_, limit in limits)])
    bits = tables["uniform"]["bits"].to_list()
    ends = [min(bits) - 0.5, max(bits) + 0.5]
    x = {"title": {"text": "bits of coefficients and operands"}, "range": ends, "dtick": 2}
    chart = figure(430, x, scale.axis(f"{STATISTICS[statistic]} of the error of {QUANTITIES[quantity].axis}"))
    for view, name in ((View.OWN, "arithmetic alone"), (View.TOTAL, "total")):
        style = VIEWS[view]
        known = [row for row in rows if row["view"] == view and row[statistic] is not None]
        add_marks(
            chart, name, known, [row["bits"] for row in known], [scale.clip(row[statistic]) for row in known],
            mode="lines+markers", line={"color": style.colour}, marker={"symbol": style.symbol, "size": 9},
        )  # fmt: skip
    for name, colour, dash, limit in limits:
        line = {"color": colour, "dash": dash}
        add_marks(chart, name, [limit, limit], ends, [scale.clip(limit[statistic])] * 2, mode="lines", line=line)
    misfits = [row for row in rows if row["view"] == View.TOTAL and is_misfit(row)]
    add_misfits(chart, misfits, [row["bits"] for row in misfits], [scale.low] * len(misfits))
    return unless_empty(chart, any(row[statistic] is not None for row in rows), "too few frames")


def _limits(tables: Tables, quantity: str, statistic: str) -> list[tuple[str, str, str, Row]]:
    """Lower limits of the error for any word length: name, colour, dash and row of errors of each line."""
    if "errors" not in tables:
        return []
    styles = {Step.CONVERTER: ("without arithmetic", BLACK, "dash"), Step.METHOD: ("the method itself", GREEN, "dot")}
    total = tables["errors"].filter(part=Part.TRAIN, view=View.TOTAL, quantity=quantity).drop_nulls(statistic)
    return [(*style, row) for step, style in styles.items() for row in total.filter(step=step).to_dicts()]


def converter(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Heat map of the error after the converter, over its bits and the noise; totals that fall have an interval."""
    table = tables["converter"].filter(quantity=quantity, step=Step.CONVERTER, view=view)
    noises, bits = (sorted(table[name].unique()) for name in ("noise_share_of_peak", "bits"))
    by_cell = {(row["noise_share_of_peak"], row["bits"]): row for row in table.iter_rows(named=True)}
    rows = [[by_cell.get((noise, b), {}) for b in bits] for noise in noises]
    values = [[row.get(statistic) for row in line] for line in rows]
    scale, name = Scale.of(value for line in values for value in line), VIEWS[View(view)].name
    fallen = falls(tables["converter"], quantity, statistic) if view == View.TOTAL else {}
    ends = {cell: f"<br>{interval(fall.few, statistic)}" for cell, fall in fallen.items()}
    texts = [
        ["" if v is None else number(v, 2) + ends.get((noise, b), "") for b, v in zip(bits, line, strict=True)]
        for noise, line in zip(noises, values, strict=True)
    ]
    shade = (lambda v: math.log10(scale.clip(v))) if scale.log else (lambda v: v)
    columns, lines = [str(b) for b in bits], [f"{100 * noise:g}" for noise in noises]
    axes = _categories("bits of the converter", columns), _categories("noise / % of the peak", lines)
    chart = figure(max(3, len(noises)) * 44 + 95, *axes)
    chart.add_heatmap(
        x=columns, y=lines,
        z=[[None if v is None else shade(v) for v in line] for line in values],
        text=texts, texttemplate="%{text}",
        hovertext=[[hover_text(name, row) if row else "" for row in line] for line in rows], hoverinfo="text",
        colorscale="Cividis", reversescale=True, showscale=False, xgap=2, ygap=2,
        name=f"{QUANTITIES[quantity].axis}, {name}",
    )  # fmt: skip
    for y, line in zip(lines, rows, strict=True):
        for x, row in zip(columns, line, strict=True):
            if row and row[statistic] is None:
                text = "×" if is_misfit(row) else "few"
                chart.add_annotation(text=text, x=x, y=y, showarrow=False, font={"color": GREY, "size": 11})
    return chart


def _categories(title: str, labels: Sequence[str]) -> dict[str, Any]:
    """An axis with all its cells, even where they are empty; a number for a place would be taken for a label."""
    axis = {"title": {"text": title}, "type": "category", "range": [-0.5, len(labels) - 0.5], "showgrid": False}
    return axis | ticks(labels) | {"tickvals": list(labels)}


def with_change(sensitivity: pl.DataFrame, errors: pl.DataFrame) -> pl.DataFrame:
    """``sensitivity`` with ``NAME_change`` for each of ``STATISTICS``: percent of the ``errors`` of the same design."""
    keys = ["quantity", "step", "view"]
    base = errors.filter(part=Part.TRAIN).select(*keys, *STATISTICS)
    joined = sensitivity.join(base, on=keys, how="left", suffix="_base", maintain_order="left")
    known = {name: pl.when(pl.col(f"{name}_base") > 0).then(pl.col(f"{name}_base")) for name in STATISTICS}
    changes = [(100 * (pl.col(name) / before - 1)).alias(f"{name}_change") for name, before in known.items()]
    return joined.with_columns(changes).drop(f"{name}_base" for name in STATISTICS)


def sensitivity(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Change of the arithmetic's error with fewer bits of each signal, the largest change by the fewest on top.

    The table is that of :func:`with_change`.
    """
    change = f"{statistic}_change"
    rows = tables["sensitivity"].filter(quantity=quantity, step=Step.ARITHMETIC)
    rows = rows.select(~cs.ends_with(*INTERVAL))  # of other frames; the change is that on the same ones
    own = rows.filter(pl.col("shorter") == pl.col("shorter").min(), view=View.OWN)
    names = own.sort(change, "signal", descending=[True, False], nulls_last=True)["signal"].to_list()
    rows = rows.filter(pl.col("signal").is_in(names), view=view)
    axis = {"title": {"text": f"change of the {STATISTICS[statistic]} / %"}, "zeroline": True}
    chart = rows_figure(names, ROW_HEIGHT, axis, barmode="group", bargap=0.25)
    colours = dict(zip(sorted(rows["shorter"].unique()), (VIEWS[View(view)].colour, ORANGE, PURPLE), strict=False))
    for (less,), some in rows.sort("shorter", maintain_order=True).group_by("shorter", maintain_order=True):
        name, marker = f"{less} bit{'s' if less != 1 else ''} less", {"color": colours.get(less, GREY)}
        misfits, fits = ([row for row in some.to_dicts() if is_misfit(row) == misfit] for misfit in (True, False))
        shown = True if less == next(iter(colours)) else "legendonly"
        group: dict[str, Any] = {"legendgroup": str(less), "visible": shown}
        bars = series(name, fits, [row[change] for row in fits], [names.index(row["signal"]) for row in fits])
        chart.add_bar(**bars, orientation="h", marker=marker, **group)
        at = [names.index(row["signal"]) for row in misfits]
        add_misfits(chart, misfits, [0.0] * len(at), at, showlegend=False, **group)
    return unless_empty(chart, rows[change].count() > 0, "too few frames")
