"""Results of a search as text: designs as good as float arithmetic, and the cost of the cheapest."""

import polars as pl

from tfra.report.numbers import number
from tfra.study.errors.cascade import SIGNED
from tfra.study.report.labels import CLOSE, CLOSE_PERCENT, Tables, cost_amount
from tfra.study.search.evaluate import CHANGE, COSTS
from tfra.study.search.trials import COMPLETE

_COST = "coefficient_kbit"


def errors_of(table: pl.DataFrame) -> list[str]:
    """The quantities whose errors trials and designs have, in the table's order."""
    return [name for name in table.columns if name in SIGNED]


def costs_of(table: pl.DataFrame) -> list[str]:
    """The costs that trials and designs have, in the table's order."""
    return [name for name in table.columns if name in COSTS]


def smallest_design(tables: Tables) -> str:
    """Like ``The smallest design within 5 % of float's total: `mixed` (199 kbit of coefficients, ...).``"""
    if "designs" not in tables:
        return ""
    judged = tables["designs"].filter(pl.col("within").is_not_null(), pl.col(_COST).is_not_null())
    close = judged.filter(pl.col("within").cast(pl.Boolean)).sort(_COST, maintain_order=True)
    if close.is_empty():
        return "" if judged.is_empty() else f"No design of the table is within {CLOSE} of float's total."
    name, cost = close.select("name", _COST).row(0)
    less = ""
    for uniform in judged.filter(name="uniform")[_COST] if name != "uniform" else ():
        less = f", {_difference(cost, uniform)} than the best uniform one, `uniform`"
    return f"The smallest design within {CLOSE} of float's total: `{name}` ({cost_amount(_COST, cost)}{less})."


def _difference(value: float, other: float) -> str:
    percent = 100 * (value / other - 1)
    return f"{number(abs(percent), 2)}\N{NO-BREAK SPACE}% {'less' if percent < 0 else 'more'}"


def cheapest_trials(tables: Tables) -> dict[str, str]:
    """A sentence for each cost: its least within the tolerance by the search, and by random choice."""
    if "trials" not in tables:
        return {}
    searches = {"trials": "", "baseline": "by random choice: "}
    start = f"Cheapest within {CLOSE} of float's errors: "
    return {
        cost: start + "; ".join(searches[n] + _cheapest(tables[n], cost) for n in searches if n in tables) + "."
        for cost in costs_of(tables["trials"])
    }


def _cheapest(trials: pl.DataFrame, cost: str) -> str:
    close = trials.filter(pl.col(CHANGE) <= CLOSE_PERCENT, state=COMPLETE).sort(cost, "number")
    if close.is_empty():
        return f"none of {len(trials):,} trials"
    least, trial = close.select(cost, "number").row(0)
    return f"{cost_amount(cost, least)} (trial {trial:,} of {len(trials):,})"
