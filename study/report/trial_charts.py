"""The chart of a search: error over cost of its trials, and of the designs that it found."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE
from tfra.study.report.figure import GREY, Scale, add_marks, figure, unless_empty
from tfra.study.report.labels import CLOSE, CLOSE_PERCENT, PLACED, SYNTHESISED, Tables, column_label
from tfra.study.search.evaluate import CHANGE
from tfra.study.search.trials import COMPLETE


def trials(tables: Tables, cost: str) -> go.Figure:
    """Complete trials over one cost; lines are the least error at each cost, with the named designs.

    A thin line leads from a design to its cost after synthesis, or after place and route.
    """
    complete = tables["trials"].filter(state=COMPLETE)
    random = tables.get("baseline", tables["trials"].clear()).filter(state=COMPLETE)
    named = _designs(tables, cost)
    known = [*complete[cost], *random[cost], *named[cost], *named["measured"].drop_nulls()]
    least, random_least = _least(complete, cost), _least(random, cost)
    x = Scale.of(known)
    across = x.axis(column_label(cost)) | ({} if x.log else {"range": None})  # it does not have to begin at zero
    ends = _growth([*complete[CHANGE], *random_least[CHANGE], *named[CHANGE], CLOSE_PERCENT])
    chart = figure(520, across, {"title": {"text": column_label(CHANGE)}, "range": ends})
    chart.add_hline(
        CLOSE_PERCENT, line={"color": BLACK, "dash": "dot", "width": 1},
        annotation={"text": f"{CLOSE} above float", "font": {"color": BLACK}},
    )  # fmt: skip

    def add(name: str, designs: pl.DataFrame, end: Sequence[float] = (), **looks: Any) -> None:
        rows = designs.to_dicts()
        costs = [row[cost] for row in rows] + [*end]
        rows += rows[-1:] * len(end)
        add_marks(chart, name, rows, list(map(x.clip, costs)), [row[CHANGE] for row in rows], **looks)

    for name, some, line in (
        ("least error", least, {"color": BLUE}),
        ("least error, random choice", random_least, {"color": GREY, "dash": "dash"}),
    ):
        # The last step continues to the end.
        add(name, some, [max(known)] if known else [], mode="lines", line={"shape": "hv", "width": 1.5} | line)
    add("trials", complete.filter(front=False), marker={"color": GREY, "size": 5, "opacity": 0.5})
    edged = {"color": BLUE, "size": 9, "line": {"width": 1, "color": "white"}}
    add("Pareto front", complete.filter(front=True), marker=edged)
    # Names are inside, and apart from their neighbours'.
    sides = [f"{'bottom' if n % 2 else 'top'} {'right' if n < len(named) / 2 else 'left'}" for n in range(len(named))]
    placed = named["fmax_mhz"].is_not_null()
    synthesised = ~placed & named["part"].is_not_null()
    for name, those, colour, symbol in (
        ("designs", ~placed & ~synthesised, ORANGE, "square-open"),
        ("designs synthesised", synthesised, PURPLE, "diamond-open"),
        ("designs placed and routed", placed, GREEN, "star-open"),
    ):
        some = named.filter(those)
        more = (some["measured"] - some[cost]).fill_null(0.0)
        whisker = {"array": more.clip(0).to_list(), "arrayminus": (-more).clip(0).to_list(), "thickness": 1}
        add(
            name, some, mode="markers+text", text=some["name"].to_list(),
            textposition=[side for side, one in zip(sides, those, strict=True) if one],
            marker={"color": colour, "symbol": symbol, "size": 15, "line": {"width": 2.5}},
            error_x=whisker | {"color": colour},
        )  # fmt: skip
    return unless_empty(chart, len(complete) > 0, "no trial is complete")


def _growth(values: Iterable[float]) -> list[float]:
    """Ends of an axis for growths of errors, which may be a little below zero, with a margin for names at both."""
    some = [value for value in values if math.isfinite(value)]
    low, high = min(0.0, *some), max(0.0, *some)
    return [low - 0.08 * (high - low), high + 0.05 * (high - low)]


def _least(complete: pl.DataFrame, cost: str) -> pl.DataFrame:
    """Trials that no cheaper one is at least as exact as."""
    order, value = complete.sort(cost, CHANGE, "number"), pl.col(CHANGE).cast(pl.Float64)
    return order.filter((value < value.cum_min().shift(1)).fill_null(True))


def _designs(tables: Tables, cost: str) -> pl.DataFrame:
    """The named designs whose error and cost are known, from the cheapest on, with the cost that was ``measured``."""
    numbers = dict.fromkeys([CHANGE, cost, SYNTHESISED + cost, PLACED + cost, "fmax_mhz"], pl.Float64)
    columns = {"name": pl.String, "part": pl.String, **numbers}
    table = tables.get("designs", pl.DataFrame(schema=columns))
    missing = {name: pl.lit(None, kind) for name, kind in columns.items() if name not in table.columns}
    known = table.with_columns(**missing).drop_nulls([CHANGE, cost]).sort(cost)
    return known.with_columns(measured=pl.coalesce(PLACED + cost, SYNTHESISED + cost))
