"""The trials of a search and the designs that it found: error over cost."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, GREEN, ORANGE
from tfra.study.report.figure import GREY, Scale, figure, say, wrapped
from tfra.study.report.found import HELD_OUT, PLACED, costs_of, errors_of
from tfra.study.report.words import CLOSE, CLOSE_PERCENT, QUANTITIES, Tables, number, taken
from tfra.study.search.evaluate import CHANGE, COSTS
from tfra.study.search.space import NAMES
from tfra.study.search.trials import COMPLETE

_TITLES = {
    "coefficient_kbit": "coefficients / kbit",
    "latency_cycles": "latency / cycles",
    "interval_cycles": "interval / cycles",
    "dsp": "DSP",
    "fmax_mhz": "f_max / MHz",
}

Place = tuple[float | None, float | None]
"""A cost and an error; a line breaks at one that is unknown."""


def title(column: str) -> str:
    """How a reader sees a cost, or the 95th percentile of a quantity's error."""
    quantity = column.removesuffix(HELD_OUT)
    if quantity in QUANTITIES:
        part = "" if column == quantity else ", held-out frames"
        return f"95th percentile of the error of {QUANTITIES[quantity].axis}{part}"
    if quantity == CHANGE:
        return "growth of the total error over float’s / %" + ("" if column == quantity else ", held-out frames")
    if column.startswith(PLACED):
        return f"{column.removeprefix(PLACED)}, placed"
    return _TITLES.get(column, column.replace("_", " "))


def trials(tables: Tables, cost: str) -> go.Figure:
    """Complete trials over one cost; lines are the least error at each cost, with the named designs."""
    complete = tables["trials"].filter(pl.col("state") == COMPLETE)
    placed, named, random = PLACED + cost, _designs(tables, cost), _random(tables)
    measured: list[Any] = named[placed].to_list() if placed in named.columns else []
    known = [value for value in (*complete[cost], *random[cost], *named[cost], *measured) if value is not None]
    line, dashed = _least(complete, cost), _least(random, cost)
    ends = (min(known), max(known)) if known else (0.0, 0.0)
    x, y = Scale.of(known), _growth([*complete[CHANGE], *dashed[CHANGE], *named[CHANGE], CLOSE_PERCENT])
    across = x.axis(title(cost)) | ({} if x.log else {"range": None})  # it does not have to begin at zero
    plane = _Plane(figure(520, across, y.axis(title(CHANGE))), cost, x, y)
    plane.add_steps("least error", line, ends[1], color=BLUE)
    plane.add_steps("least error, random choice", dashed, ends[1], "random choice, trial", color=GREY, dash="dash")
    level, name = {"color": BLACK, "dash": "dot", "width": 1}, f"{CLOSE} above float"
    plane.add(name, [(end, CLOSE_PERCENT) for end in ends if known], name, mode="lines", line=level)
    front = pl.col("front")
    plane.add_trials("trials", complete.filter(~front), marker={"color": GREY, "size": 5, "opacity": 0.5})
    edged = {"color": BLUE, "size": 9, "line": {"width": 1, "color": "white"}}
    plane.add_trials("Pareto front", complete.filter(front), marker=edged)
    plane.add_designs(named)
    return plane.shown if len(complete) else say(plane.shown, "no trial is complete")


@dataclass(frozen=True)
class _Plane:
    """A figure of designs: cost across, error up."""

    shown: go.Figure
    cost: str
    x: Scale
    y: Scale

    def add(self, name: str, places: Sequence[Place], texts: str | Sequence[str], **looks: Any) -> None:
        """Add a series, unless it is empty."""
        if not places:
            return
        x, y = zip(*((_placed(self.x, cost), _placed(self.y, error)) for cost, error in places), strict=True)
        self.shown.add_scatter(x=x, y=y, name=name, hovertext=texts, hoverinfo="text", **{"mode": "markers"} | looks)

    def add_trials(self, name: str, rows: pl.DataFrame, **looks: Any) -> None:
        """Add trials, with their choices as hover text."""
        self.add(name, rows.select(self.cost, CHANGE).rows(), _texts(rows, "trial"), **looks)

    def add_steps(self, name: str, rows: pl.DataFrame, end: float, who: str = "trial", **looks: Any) -> None:
        """Add a line from trial to trial, each of a smaller error; the last step continues to the cost ``end``."""
        if len(rows):
            places, texts = rows.select(self.cost, CHANGE).rows(), _texts(rows, who)
            places.append((end, places[-1][1]))
            self.add(name, places, [*texts, texts[-1]], mode="lines", line={"shape": "hv", "width": 1.5} | looks)

    def add_designs(self, named: pl.DataFrame) -> None:
        """Add named designs at their estimate, and where placing them has led to."""
        placed = pl.col("fmax_mhz").is_not_null()
        named = named.sort(self.cost).with_columns(side=pl.Series(_sides(len(named)), dtype=pl.String))
        for name, rows, colour, symbol in (
            ("designs", named.filter(~placed), ORANGE, "square"),
            ("designs placed and routed", named.filter(placed), GREEN, "star"),
        ):
            marker = {"color": colour, "symbol": f"{symbol}-open", "size": 15, "line": {"width": 2.5}}
            labels: dict[str, Any] = {"mode": "markers+text", "text": rows["name"].to_list()}
            labels["textposition"] = rows["side"].to_list()
            texts = [_design_text(row) for row in rows.iter_rows(named=True)]
            self.add(name, rows.select(self.cost, CHANGE).rows(), texts, marker=marker, **labels)
        self._add_measured(named.filter(placed))

    def _add_measured(self, rows: pl.DataFrame) -> None:
        """Add a thin line from the estimate of each placed design to what was measured."""
        if PLACED + self.cost not in rows.columns:
            return
        places: list[Place] = []
        texts: list[str] = []
        for row in rows.iter_rows(named=True):
            error, text = row[CHANGE], _design_text(row)
            places += [(row[self.cost], error), (row[PLACED + self.cost], error), (None, None)]
            texts += [text, text, ""]
        sizes = [0, 10, 0] * len(rows)
        marker = {"symbol": "line-ns-open", "size": sizes, "color": GREEN, "line": {"width": 2, "color": GREEN}}
        line = {"color": GREEN, "width": 1}
        self.add("measured", places, texts, mode="lines+markers", line=line, marker=marker)


def _growth(values: Iterable[float]) -> Scale:
    """Of the growth of errors, which may be a little below zero; names need room at both ends."""
    some = [value for value in values if math.isfinite(value)]
    low, high = min(0.0, *some), max(0.0, *some)
    return Scale(False, low - 0.08 * (high - low), high + 0.05 * (high - low))


def _sides(count: int) -> list[str]:
    """Where names stand, from the cheapest design on: inside, and apart from their neighbours'."""
    return [f"{'bottom' if n % 2 else 'top'} {'right' if n < count / 2 else 'left'}" for n in range(count)]


def _placed(scale: Scale, value: float | None) -> float | None:
    return None if value is None else scale.place(value)


def _least(complete: pl.DataFrame, cost: str) -> pl.DataFrame:
    """Trials that no cheaper one is at least as exact as."""
    order, value = complete.sort(cost, CHANGE, "number"), pl.col(CHANGE).cast(pl.Float64)
    return order.filter((value < value.cum_min().shift(1)).fill_null(True))


def _random(tables: Tables) -> pl.DataFrame:
    """The complete trials of random choice, if there are any."""
    return tables.get("baseline", tables["trials"].clear()).filter(pl.col("state") == COMPLETE)


def _designs(tables: Tables, cost: str) -> pl.DataFrame:
    """The named designs whose error and cost are known."""
    numbers = dict.fromkeys([CHANGE, cost, "fmax_mhz"], pl.Float64)
    table = tables.get("designs", pl.DataFrame(schema={"name": pl.String, **numbers}))
    missing = {name: pl.lit(None, pl.Float64) for name in numbers if name not in table.columns}
    return table.with_columns(**missing).filter(pl.col(CHANGE).is_not_null(), pl.col(cost).is_not_null())


def _texts(rows: pl.DataFrame, who: str) -> list[str]:
    values = [CHANGE, *errors_of(rows), *costs_of(rows)]
    chosen = [name for name in rows.columns if name in NAMES]
    return [_trial_text(row, who, values, chosen) for row in rows.iter_rows(named=True)]


def _trial_text(row: Mapping[str, Any], who: str, values: Sequence[str], chosen: Sequence[str]) -> str:
    said = [_value_text(row, name) for name in values if row[name] is not None]
    lengths = [f"{name} {row[name]}" for name in chosen if row[name] is not None]
    lines = [", ".join(lengths[n : n + 2]) for n in range(0, len(lengths), 2)]
    return "<br>".join([f"<b>{who} {row['number']}</b>", *said, *lines])


def _value_text(row: Mapping[str, Any], name: str) -> str:
    """A number of a design, and beside it that of held-out frames, or the measured one."""
    kind = QUANTITIES.get(name)
    said = f"error of {kind.label}: {kind.amount(row[name], 3)}" if kind else f"{title(name)}: {taken(row[name])}"
    for other, beside in ((name + HELD_OUT, "held-out"), (PLACED + name, "placed")):
        if row.get(other) is not None:
            said += f", {beside} {number(row[other]) if kind else taken(row[other])}"
    return said


def _design_text(row: Mapping[str, Any]) -> str:
    shown = [name for name in row if name in QUANTITIES or name in (CHANGE, *COSTS, "fmax_mhz")]
    said = [_value_text(row, name) for name in shown if row[name] is not None]
    return "<br>".join([f"<b>{row['name']}</b>", wrapped(row["formats"]), *said])
