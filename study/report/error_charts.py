"""A function for each chart of errors: from tables to a figure, whose numbers are those of the tables.

Arithmetic alone is blue, totals are vermilion; series that differ in colour also differ in shape or dash.
"""

import math
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION
from tfra.report.numbers import listed, number
from tfra.study.errors.cascade import Step, View
from tfra.study.frames.block import Part
from tfra.study.report.figure import (
    GREY,
    ROW_HEIGHT,
    Dot,
    Rows,
    Scale,
    add_bars,
    add_dots,
    add_marks,
    add_misfits,
    figure,
    hover_text,
    misfit_text,
    rows_figure,
    unless_empty,
)
from tfra.study.report.labels import QUANTITIES, STATISTICS, STEPS, VARIANTS, Tables, cost_amount, setting

Row = dict[str, Any]
"""Of a table, by column."""

VIEWS = {View.OWN: ("its own share", BLUE, "circle"), View.TOTAL: ("total", VERMILION, "diamond")}

FLIPS = {
    "status": "status flags",
    "quadrant": "quadrant of φ",
    "swept_variable": "swept variable",
    "sweep_index_off_by_one": "index off by one",
    "sweep_index_off_by_more": "index off by more",
}
"""Decisions whose rate is that of a change, and their labels."""

_OFFSETS = {View.OWN: -0.15, View.TOTAL: 0.15}
"""Of the two views of a row from its middle."""


def cascade(tables: Tables, quantity: str, part: str) -> go.Figure:
    """Median and 95th percentile of each step's own share and of the total after it."""
    rows = tables["errors"].filter(quantity=quantity, part=part).to_dicts()
    steps = list(Step)
    lines = Rows.plain([STEPS[step] for step in steps])
    return _spread(rows, [steps.index(row["step"]) for row in rows], lines, quantity, 62)


def variants(tables: Tables, quantity: str, view: str) -> go.Figure:
    """One view of the arithmetic's errors, for each variant of the design."""
    rows = tables["variants"].filter(quantity=quantity, step=Step.ARITHMETIC, view=view).to_dicts()
    settings = [(row["variant"], row[VARIANTS[row["variant"]][0]]) for row in rows]
    distinct = list(dict.fromkeys(settings))
    lines = Rows.grouped([VARIANTS[name][1] for name, _ in distinct], [setting(value) for _, value in distinct])
    positions = dict(zip(distinct, lines.numbers, strict=True))
    return _spread(rows, [positions[each] for each in settings], lines, quantity, 24)


def _spread(rows: list[Row], positions: list[int], lines: Rows, quantity: str, height: int) -> go.Figure:
    """The errors of every row at its position; where there are both views, beside each other."""
    scale = Scale.of(row[name] for row in rows for name in ("median", "p95"))
    chart = rows_figure(lines, height, scale.axis(f"error of {QUANTITIES[quantity].axis}"))
    views = {row["view"] for row in rows}
    for view, (name, colour, symbol) in VIEWS.items():
        offset = _OFFSETS[view] if len(views) > 1 else 0.0
        dots = [
            Dot(position + offset, row["median"], row["median"], row["p95"] or row["median"], _error_text(row, name))
            for position, row in zip(positions, rows, strict=True)
            if row["view"] == view and row["median"] is not None
        ]
        add_dots(chart, scale, name, colour, symbol, dots)
    misfits = [(position, row) for position, row in zip(positions, rows, strict=True) if _is_misfit(row)]
    add_misfits(chart, [(scale.low, position) for position, _ in misfits], [misfit_text(row) for _, row in misfits])
    return unless_empty(chart, any(row["median"] is not None for row in rows), "too few frames")


def _is_misfit(row: Row) -> bool:
    """Whether a variation has no numbers, since its choices do not fit together."""
    return row.get("reason") is not None


def _error_text(row: Row, name: str, *lines: str) -> str:
    """All amounts of a row of errors, and what was changed, of a row of variants."""
    kind = QUANTITIES[row["quantity"]]
    amounts = {"median": "median", "p95": "95th percentile", "p99_9": "99.9th percentile", "worst": "worst"}
    known = [f"{label}: {kind.amount(row[key], 3)}" for key, label in amounts.items() if row.get(key) is not None]
    if "variant" in row:
        column, label = VARIANTS[row["variant"]]
        lines = (*lines, f"{label}: {setting(row[column])}")
    return hover_text(f"{STEPS[row['step']]}, {name}", *known, f"{row['count']:,} frames", *lines)


def flips(tables: Tables, part: str) -> go.Figure:
    """How often each step's decision differs from that of the step before, with its interval."""
    known = pl.col("rate").is_not_null(), pl.col("decision").is_in(list(FLIPS))
    rows = tables["flips"].filter(*known, part=part).to_dicts()
    scale = Scale.of(100 * row[name] for row in rows for name in ("rate", "rate_low", "rate_high"))
    chart = rows_figure(Rows.plain(list(FLIPS.values())), 54, scale.axis("frames that flip / %"))
    series = {Step.NOISE: (PURPLE, "square"), Step.CONVERTER: (GREEN, "diamond"), Step.ARITHMETIC: (BLUE, "circle")}
    order = list(FLIPS)
    for n, (step, (colour, symbol)) in enumerate(series.items()):
        dots = []
        for row in rows:
            if row["step"] == step:
                rate, low, high = (100 * row[name] for name in ("rate", "rate_low", "rate_high"))
                dots.append(Dot(order.index(row["decision"]) + 0.24 * (n - 1), rate, low, high, _flip_text(row)))
        add_dots(chart, scale, STEPS[step], colour, symbol, dots)
    return unless_empty(chart, bool(rows), "no frames to compare")


def _flip_text(row: Row) -> str:
    rate, low, high = (number(100 * row[name]) for name in ("rate", "rate_low", "rate_high"))
    frames = f"{row['frames']:,} of {row['of']:,} frames: {rate} %"
    return hover_text(f"{FLIPS[row['decision']]}, {STEPS[row['step']]}", frames, f"95 % confidence: {low} to {high} %")


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
        _, colour, symbol = VIEWS[view]
        known = [row for row in rows if row["view"] == view and row[statistic] is not None]
        add_marks(
            chart, name, [(row["bits"], scale.clip(row[statistic])) for row in known],
            [_error_text(row, name, _cost_text(row)) for row in known], mode="lines+markers",
            line={"color": colour}, marker={"symbol": symbol, "size": 9},
        )  # fmt: skip
    for name, colour, dash, limit in limits:
        points = [(end, scale.clip(limit[statistic])) for end in ends]
        line = {"color": colour, "dash": dash}
        add_marks(chart, name, points, _error_text(limit, "total"), mode="lines", line=line)
    misfits = [row for row in rows if row["view"] == View.TOTAL and _is_misfit(row)]
    add_misfits(chart, [(row["bits"], scale.low) for row in misfits], list(map(misfit_text, misfits)))
    return unless_empty(chart, any(row[statistic] is not None for row in rows), "too few frames")


def _limits(tables: Tables, quantity: str, statistic: str) -> list[tuple[str, str, str, Row]]:
    """Lower limits of the error for any word length: name, colour, dash and row of errors of each line."""
    if "errors" not in tables:
        return []
    styles = {Step.CONVERTER: ("without arithmetic", BLACK, "dash"), Step.METHOD: ("the method itself", GREEN, "dot")}
    rows = tables["errors"].filter(part=Part.TRAIN, view=View.TOTAL, quantity=quantity).to_dicts()
    return [
        (*style, row)
        for step, style in styles.items()
        for row in rows
        if row["step"] == step and row[statistic] is not None
    ]


def _cost_text(row: Row) -> str:
    costs = [cost_amount(name, row[name]) for name in ("coefficient_kbit", "dsp")]
    return f"{row['bits']}×{row['bits']} bits: {listed(costs)}"


def converter(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Heat map of the error after the converter, over its bits and the noise before it."""
    table = tables["converter"].filter(quantity=quantity, step=Step.CONVERTER, view=view)
    noises, bits = (sorted(table[name].unique()) for name in ("noise_share_of_peak", "bits"))
    by_cell = {(row["noise_share_of_peak"], row["bits"]): row for row in table.iter_rows(named=True)}
    rows = [[by_cell.get((noise, b), {}) for b in bits] for noise in noises]
    values = [[row.get(statistic) for row in line] for line in rows]
    scale, name = Scale.of(value for line in values for value in line), VIEWS[View(view)][0]
    shade = (lambda v: math.log10(scale.clip(v))) if scale.log else (lambda v: v)
    columns, lines = [str(b) for b in bits], [f"{100 * noise:g}" for noise in noises]
    axes = _categories("bits of the converter", columns), _categories("noise / % of the peak", lines)
    chart = figure(max(3, len(noises)) * 44 + 95, *axes)
    chart.add_heatmap(
        x=columns, y=lines,
        z=[[None if v is None else shade(v) for v in line] for line in values],
        text=[["" if v is None else number(v, 2) for v in line] for line in values], texttemplate="%{text}",
        hovertext=[[_cell_text(row, name) for row in line] for line in rows], hoverinfo="text",
        colorscale="Cividis", reversescale=True, showscale=False, xgap=2, ygap=2,
        name=f"{QUANTITIES[quantity].axis}, {name}",
    )  # fmt: skip
    for y, line in enumerate(rows):  # positions on an axis of categories are numbers
        for x, row in enumerate(line):
            if row and row[statistic] is None:
                text = "×" if _is_misfit(row) else "few"
                chart.add_annotation(text=text, x=x, y=y, showarrow=False, font={"color": GREY, "size": 11})
    return chart


def _categories(title: str, labels: Sequence[str]) -> dict[str, Any]:
    """An axis with all its cells, even where they are empty."""
    ticks = {"tickvals": list(range(len(labels))), "ticktext": list(labels), "ticks": ""}
    ends = [-0.5, len(labels) - 0.5]
    return {"title": {"text": title}, "type": "category", "range": ends, "showgrid": False, **ticks}


def _cell_text(row: Row, name: str) -> str:
    if not row:
        return ""
    if _is_misfit(row):
        return misfit_text(row)
    return _error_text(row, name, f"{row['bits']}-bit converter, noise {100 * row['noise_share_of_peak']:g} %")


def with_change(sensitivity: pl.DataFrame, errors: pl.DataFrame) -> pl.DataFrame:
    """``sensitivity`` with ``NAME_change`` for each of ``STATISTICS``: percent of the ``errors`` of the same design."""
    keys = ["quantity", "step", "view"]
    base = errors.filter(part=Part.TRAIN).select(*keys, *STATISTICS)
    joined = sensitivity.join(base, on=keys, how="left", suffix="_base", maintain_order="left")
    known = {name: pl.when(pl.col(f"{name}_base") > 0).then(pl.col(f"{name}_base")) for name in STATISTICS}
    changes = [(100 * (pl.col(name) / before - 1)).alias(f"{name}_change") for name, before in known.items()]
    return joined.with_columns(changes).drop(f"{name}_base" for name in STATISTICS)


def sensitivity(tables: Tables, quantity: str, statistic: str, view: str) -> go.Figure:
    """Change of the arithmetic's error with one bit less of each signal, the largest change on top.

    The table is that of :func:`with_change`.
    """
    change = f"{statistic}_change"
    rows = tables["sensitivity"].filter(quantity=quantity, step=Step.ARITHMETIC)
    own = rows.filter(view=View.OWN, shorter=1)
    names = own.sort(change, "signal", descending=[True, False], nulls_last=True)["signal"].to_list()
    rows = rows.filter(pl.col("signal").is_in(names), view=view)
    axis = {"title": {"text": f"change of the {STATISTICS[statistic]} / %"}, "zeroline": True}
    chart = rows_figure(Rows.plain(names), ROW_HEIGHT, axis, barmode="group", bargap=0.25)
    colours = {1: VIEWS[View(view)][1], 2: ORANGE, 4: PURPLE}
    for (less,), some in rows.group_by("shorter", maintain_order=True):
        misfits, fits = ([row for row in some.to_dicts() if _is_misfit(row) == misfit] for misfit in (True, False))
        group: dict[str, Any] = {"legendgroup": str(less), "visible": True if less == 1 else "legendonly"}
        add_bars(
            chart, f"{less} bit{'s' if less != 1 else ''} less",
            [(row[change], names.index(row["signal"])) for row in fits],
            [_change_text(row, view, row[change]) for row in fits],
            marker={"color": colours.get(less, GREY)}, **group,
        )  # fmt: skip
        add_misfits(
            chart, [(0.0, names.index(row["signal"])) for row in misfits],
            [f"{_length_text(row)}<br>{misfit_text(row)}" for row in misfits], showlegend=False, **group,
        )  # fmt: skip
    return unless_empty(chart, rows[change].count() > 0, "too few frames")


def _change_text(row: Row, view: str, change: float | None) -> str:
    equal = row["sweep_index_equal"]
    lines = [_length_text(row), "change unknown" if change is None else f"{change:+.3g} %"]
    lines += [] if equal is None else [f"sweep index as float’s: {number(100 * equal)} %"]
    return _error_text(row, VIEWS[View(view)][0], *lines)


def _length_text(row: Row) -> str:
    """The bits that a signal is left."""
    return f"<b>{row['signal']}</b>: {row['bits']} of {row['bits'] + row['shorter']} bits ({row['shorter']} fewer)"
