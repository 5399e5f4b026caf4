"""The trials of a search and the designs that came out of it: which error costs how much."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.codegen.colours import BLUE, GREEN, ORANGE
from tfra.study.report.figure import GREY, Scale, figure
from tfra.study.report.words import QUANTITIES, STATISTICS, Tables, number
from tfra.study.search.space import NAMES
from tfra.study.search.trials import COMPLETE

_STATED = ("number", "generation", "state", "front", "reason")

_TITLES = {
    "coefficient_kbit": "coefficients / kbit",
    "dsp": "DSP",
    "bram": "BRAM",
    "lut": "LUT, estimated",
    "lut_placed": "LUT, placed",
    "latency_cycles": "latency / cycles",
    "fmax_mhz": "f_max / MHz",
}


def objectives(trials: pl.DataFrame) -> list[str]:
    """What a search made small, in its order; the first is an error, the others are costs."""
    return [name for name in trials.columns if name not in (*_STATED, *NAMES)]


def choices(trials: pl.DataFrame) -> list[str]:
    """What a search chose."""
    return [name for name in trials.columns if name in NAMES]


def title(column: str) -> str:
    """How a reader sees an objective; the errors of a quantity begin with its name."""
    for quantity, kind in QUANTITIES.items():
        if column.startswith(quantity):
            rest = [STATISTICS.get(word, word) for word in re.split("[._]+", column.removeprefix(quantity)) if word]
            return f"error of {kind.axis}" + (f", {' '.join(rest)}" if rest else "")
    return _TITLES.get(column, column.replace("_", " "))


def trials(tables: Tables, cost: str) -> go.Figure:
    """Complete trials over one cost; the line is the least error that each cost buys, named designs stand on it."""
    complete = tables["trials"].filter(pl.col("state") == COMPLETE)
    error = objectives(complete)[0]
    named = _designs(tables, error, cost)
    scales = {name: Scale.of([*complete[name], *named[name]]) for name in (cost, error)}
    x = scales[cost].axis(title(cost)) | ({} if scales[cost].log else {"range": None})
    middle = median(named[cost]) if len(named) else 0.0
    shown = figure(520, x, scales[error].axis(title(error)))

    def add(rows: pl.DataFrame, name: str, hover: Sequence[str], **looks: Any) -> None:
        across, up = ([scales[key].place(value) for value in rows[key]] for key in (cost, error))
        shown.add_scatter(x=across, y=up, name=name, hovertext=hover, hoverinfo="text", **{"mode": "markers"} | looks)

    line = _least(complete, cost, error)
    add(line, "least error", _texts(line, tables), mode="lines", line={"color": BLUE, "shape": "hv", "width": 1})
    others, front = complete.filter(~pl.col("front")), complete.filter(pl.col("front"))
    add(others, "trials", _texts(others, tables), marker={"color": GREY, "size": 5, "opacity": 0.5})
    edged = {"color": BLUE, "size": 9, "line": {"width": 1, "color": "white"}}
    add(front, "Pareto front", _texts(front, tables), marker=edged)
    for name, rows, colour, symbol in (
        ("designs", named.filter(~pl.col("placed")), ORANGE, "square"),
        ("designs placed and routed", named.filter(pl.col("placed")), GREEN, "star"),
    ):
        if len(rows):
            marker = {"color": colour, "symbol": f"{symbol}-open", "size": 15, "line": {"width": 2.5}}
            sides = ["top right" if value < middle else "bottom left" for value in rows[cost]]
            texts = [_design_text(row) for row in rows.iter_rows(named=True)]
            add(rows, name, texts, mode="markers+text", marker=marker, text=rows["name"], textposition=sides)
    return shown


def _least(complete: pl.DataFrame, cost: str, error: str) -> pl.DataFrame:
    """Trials that no cheaper one is at least as exact as."""
    order = complete.sort(cost, error, "number")
    return order.filter((pl.col(error) < pl.col(error).cum_min().shift(1)).fill_null(True))


def _designs(tables: Tables, error: str, cost: str) -> pl.DataFrame:
    """The named designs whose error and cost are known, and whether they are ``placed``."""
    empty = pl.DataFrame(schema={"name": pl.String, error: pl.Float64, cost: pl.Float64, "placed": pl.Boolean})
    table = tables.get("designs", empty)
    if not {error, cost} <= set(table.columns):
        return empty
    placed = pl.col("fmax_mhz").is_not_null() if "fmax_mhz" in table.columns else pl.lit(False)
    return table.with_columns(placed=placed).filter(pl.col(error).is_not_null(), pl.col(cost).is_not_null())


def _texts(rows: pl.DataFrame, tables: Tables) -> list[str]:
    goals, chosen = objectives(tables["trials"]), choices(tables["trials"])
    return [_trial_text(row, goals, chosen) for row in rows.iter_rows(named=True)]


def _trial_text(row: Mapping[str, Any], goals: Sequence[str], chosen: Sequence[str]) -> str:
    values = [f"{title(name)}: {number(row[name], 4)}" for name in goals if row[name] is not None]
    lengths = [f"{name} {row[name]}" for name in chosen if row[name] is not None]
    lines = [", ".join(lengths[n : n + 3]) for n in range(0, len(lengths), 3)]
    return "<br>".join([f"<b>trial {row['number']}</b>", *values, *lines])


def _design_text(row: Mapping[str, Any]) -> str:
    values = [f"{title(name)}: {number(value, 4)}" for name, value in row.items() if _is_number(value)]
    return "<br>".join([f"<b>{row['name']}</b>", *([row["formats"]] if row.get("formats") else []), *values])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
