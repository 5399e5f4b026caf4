"""Results of a search as text: designs as good as float arithmetic, and the cost of the cheapest."""

from __future__ import annotations

import polars as pl

from tfra.study.errors.cascade import SIGNED
from tfra.study.report.words import CLOSE, CLOSE_PERCENT, Tables, amount, cell, number
from tfra.study.search.evaluate import CHANGE, COSTS
from tfra.study.search.trials import COMPLETE

HELD_OUT, PLACED = "_held_out", "placed_"
"""Suffix of a quantity's name, and prefix of a cost's name, in the table of designs."""


def errors_of(table: pl.DataFrame) -> list[str]:
    """The quantities whose errors trials and designs have, in the table's order."""
    return [name for name in table.columns if name in SIGNED]


def costs_of(table: pl.DataFrame) -> list[str]:
    """The costs that trials and designs have, in the table's order."""
    return [name for name in table.columns if name in COSTS]


def smallest(tables: Tables) -> str:
    """Like ``The smallest design within 5 % of float's total: `mixed` (199 kbit of coefficients, ...).``"""
    if "designs" not in tables:
        return ""
    cost = "coefficient_kbit"
    judged = tables["designs"].filter(pl.col("within").is_not_null(), pl.col(cost).is_not_null())
    close = judged.filter(pl.col("within").cast(pl.Boolean)).sort(cost, maintain_order=True)
    if close.is_empty():
        return "" if judged.is_empty() else f"No design of the table is within {CLOSE} of float's total."
    name, kbit = close.select("name", cost).row(0)
    uniform = cell(judged, cost, name="uniform")
    less = f", {_less(kbit, uniform)} than the best uniform one, `uniform`" if uniform and name != "uniform" else ""
    return f"The smallest design within {CLOSE} of float's total: `{name}` ({amount(cost, kbit)}{less})."


def _less(value: float, other: float) -> str:
    change = 100 * (value / other - 1)
    return f"{number(abs(change), 2)}\N{NO-BREAK SPACE}% {'less' if change < 0 else 'more'}"


def compared(tables: Tables) -> dict[str, str]:
    """By cost, what the cheapest design takes that the search found within the tolerance, and that of random choice."""
    if "trials" not in tables:
        return {}
    names = {"trials": "", "baseline": "by random choice: "}
    there = {text: tables[name] for name, text in names.items() if name in tables}
    start = f"Cheapest within {CLOSE} of float's errors: "
    return {
        cost: start + "; ".join(text + _cheapest(table, cost) for text, table in there.items()) + "."
        for cost in costs_of(tables["trials"])
    }


def _cheapest(trials: pl.DataFrame, cost: str) -> str:
    found = trials.filter(pl.col("state") == COMPLETE, pl.col(CHANGE) <= CLOSE_PERCENT).sort(cost, "number")
    if found.is_empty():
        return f"none of {len(trials):,} trials"
    taken, trial = found.select(cost, "number").row(0)
    return f"{amount(cost, taken)} (trial {trial:,} of {len(trials):,})"
