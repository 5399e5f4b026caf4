"""The chart of a search: error over cost of its trials, and of the designs that it found."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE
from tfra.report.numbers import number
from tfra.study.report.figure import GREY, Point, Scale, add_marks, figure, hover_text, unless_empty, wrapped
from tfra.study.report.labels import (
    CLOSE,
    CLOSE_PERCENT,
    HELD_OUT,
    PLACED,
    QUANTITIES,
    Tables,
    column_label,
    resource_count,
)
from tfra.study.report.results import costs_of, errors_of
from tfra.study.search.evaluate import CHANGE, COSTS
from tfra.study.search.space import NAMES
from tfra.study.search.trials import COMPLETE


def trials(tables: Tables, cost: str) -> go.Figure:
    """Complete trials over one cost; lines are the least error at each cost, with the named designs."""
    complete = tables["trials"].filter(state=COMPLETE)
    random = tables.get("baseline", tables["trials"].clear()).filter(state=COMPLETE)
    named = _designs(tables, cost)
    known = _known(cost, complete, random, named)
    end = max(known, default=0.0)
    least, random_least = _least(complete, cost), _least(random, cost)
    x, y = Scale.of(known), _growth([*complete[CHANGE], *random_least[CHANGE], *named[CHANGE], CLOSE_PERCENT])
    across = x.axis(column_label(cost)) | ({} if x.log else {"range": None})  # it does not have to begin at zero
    plane = _Plane(figure(520, across, y.axis(column_label(CHANGE))), cost, x, y)
    plane.add_steps("least error", "trial", least, end, color=BLUE)
    style = {"color": GREY, "dash": "dash"}
    plane.add_steps("least error, random choice", "random choice, trial", random_least, end, **style)
    level, name = {"color": BLACK, "dash": "dot", "width": 1}, f"{CLOSE} above float"
    ends = [(min(known), CLOSE_PERCENT), (max(known), CLOSE_PERCENT)] if known else []
    plane.add(name, ends, name, mode="lines", line=level)
    plane.add_trials("trials", complete.filter(front=False), marker={"color": GREY, "size": 5, "opacity": 0.5})
    edged = {"color": BLUE, "size": 9, "line": {"width": 1, "color": "white"}}
    plane.add_trials("Pareto front", complete.filter(front=True), marker=edged)
    plane.add_designs(named)
    return unless_empty(plane.chart, len(complete) > 0, "no trial is complete")


@dataclass(frozen=True)
class _Plane:
    """A chart of designs: cost across, error up."""

    chart: go.Figure
    cost: str
    x: Scale
    y: Scale

    def add(self, name: str, points: Sequence[Point], texts: str | Sequence[str], **looks: Any) -> None:
        """Add a series, unless it is empty."""
        clipped = [
            (None if cost is None else self.x.clip(cost), None if error is None else self.y.clip(error))
            for cost, error in points
        ]
        add_marks(self.chart, name, clipped, texts, **looks)

    def add_trials(self, name: str, rows: pl.DataFrame, **looks: Any) -> None:
        """Add trials, with their choices as hover text."""
        self.add(name, rows.select(self.cost, CHANGE).rows(), _trial_texts(rows, "trial"), **looks)

    def add_steps(self, name: str, kind: str, rows: pl.DataFrame, end: float, **looks: Any) -> None:
        """Add a line from trial to trial, each of a smaller error; the last step continues to the cost ``end``."""
        if len(rows):
            points, texts = rows.select(self.cost, CHANGE).rows(), _trial_texts(rows, kind)
            points.append((end, points[-1][1]))
            self.add(name, points, [*texts, texts[-1]], mode="lines", line={"shape": "hv", "width": 1.5} | looks)

    def add_designs(self, named: pl.DataFrame) -> None:
        """Add named designs at their estimate, with a thin line to what was measured after place and route."""
        placed = pl.col("fmax_mhz").is_not_null()
        named = named.sort(self.cost).with_columns(side=pl.Series(_sides(len(named)), dtype=pl.String))
        for name, rows, colour, symbol in (
            ("designs", named.filter(~placed), ORANGE, "square"),
            ("designs placed and routed", named.filter(placed), GREEN, "star"),
        ):
            marker = {"color": colour, "symbol": f"{symbol}-open", "size": 15, "line": {"width": 2.5}}
            texts = [_design_text(row) for row in rows.iter_rows(named=True)]
            self.add(
                name, rows.select(self.cost, CHANGE).rows(), texts, marker=marker, mode="markers+text",
                text=rows["name"].to_list(), textposition=rows["side"].to_list(),
            )  # fmt: skip
        if PLACED + self.cost in named.columns:
            self._add_measured(named.filter(placed).to_dicts())

    def _add_measured(self, rows: Sequence[Mapping[str, Any]]) -> None:
        points: list[Point] = []
        texts: list[str] = []
        for row in rows:
            points += [(row[self.cost], row[CHANGE]), (row[PLACED + self.cost], row[CHANGE]), (None, None)]
            texts += [_design_text(row), _design_text(row), ""]
        line = {"color": GREEN, "width": 1}
        marker = {
            "symbol": "line-ns-open",
            "size": [0, 10, 0] * len(rows),
            "color": GREEN,
            "line": {"width": 2, "color": GREEN},
        }
        self.add("measured", points, texts, mode="lines+markers", line=line, marker=marker)


def _known(cost: str, complete: pl.DataFrame, random: pl.DataFrame, named: pl.DataFrame) -> list[float]:
    """Every cost on the chart."""
    columns = [complete[cost], random[cost], named[cost]]
    columns += [named[PLACED + cost]] if PLACED + cost in named.columns else []
    return [value for column in columns for value in column.drop_nulls()]


def _growth(values: Iterable[float]) -> Scale:
    """Of the growth of errors, which may be a little below zero, with a margin for names at both ends."""
    some = [value for value in values if math.isfinite(value)]
    low, high = min(0.0, *some), max(0.0, *some)
    return Scale(False, low - 0.08 * (high - low), high + 0.05 * (high - low))


def _sides(count: int) -> list[str]:
    """Sides of the names, from the cheapest design on: inside, and apart from their neighbours'."""
    return [f"{'bottom' if n % 2 else 'top'} {'right' if n < count / 2 else 'left'}" for n in range(count)]


def _least(complete: pl.DataFrame, cost: str) -> pl.DataFrame:
    """Trials that no cheaper one is at least as exact as."""
    order, value = complete.sort(cost, CHANGE, "number"), pl.col(CHANGE).cast(pl.Float64)
    return order.filter((value < value.cum_min().shift(1)).fill_null(True))


def _designs(tables: Tables, cost: str) -> pl.DataFrame:
    """The named designs whose error and cost are known."""
    numbers = dict.fromkeys([CHANGE, cost, "fmax_mhz"], pl.Float64)
    table = tables.get("designs", pl.DataFrame(schema={"name": pl.String, **numbers}))
    missing = {name: pl.lit(None, pl.Float64) for name in numbers if name not in table.columns}
    return table.with_columns(**missing).filter(pl.col(CHANGE).is_not_null(), pl.col(cost).is_not_null())


def _trial_texts(rows: pl.DataFrame, kind: str) -> list[str]:
    """Values of each trial, then its choices, two a line."""
    values = [CHANGE, *errors_of(rows), *costs_of(rows)]
    choices = [name for name in rows.columns if name in NAMES]
    texts = []
    for row in rows.iter_rows(named=True):
        lengths = [f"{name} {row[name]}" for name in choices if row[name] is not None]
        lines = [", ".join(lengths[n : n + 2]) for n in range(0, len(lengths), 2)]
        texts.append(hover_text(f"{kind} {row['number']}", *_value_texts(row, values), *lines))
    return texts


def _design_text(row: Mapping[str, Any]) -> str:
    values = [name for name in row if name in QUANTITIES or name in (CHANGE, *COSTS, "fmax_mhz")]
    return hover_text(row["name"], wrapped(row["formats"]), *_value_texts(row, values))


def _value_texts(row: Mapping[str, Any], names: Sequence[str]) -> list[str]:
    """Known numbers of a design, and beside each that of held-out frames, or the measured one."""
    texts = []
    for name in names:
        if row[name] is None:
            continue
        kind = QUANTITIES.get(name)
        text = f"{column_label(name)}: {resource_count(row[name])}"
        if kind:
            text = f"error of {kind.label}: {kind.amount(row[name], 3)}"
        for other, label in ((name + HELD_OUT, "held-out"), (PLACED + name, "placed")):
            if row.get(other) is not None:
                text += f", {label} {number(row[other]) if kind else resource_count(row[other])}"
        texts.append(text)
    return texts
