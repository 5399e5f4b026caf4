"""Rows of the tables that compare designs of a skin's window: other word lengths, other converters."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import polars as pl

from tfra.study.errors.cascade import View
from tfra.study.errors.statistics import ERRORS, INTERVAL
from tfra.study.errors.variation import Variation
from tfra.study.skins.cascade import SIGNED
from tfra.study.skins.statistics import ALL, KINDS, errors, finding

COLUMNS = ERRORS | {
    "contacts": pl.Int64,
    "left_out": pl.Int64,
    **dict.fromkeys([f"{kind}{end}" for kind in KINDS for end in ("", *INTERVAL)], pl.Float64),
    "reason": pl.String,
}
"""Columns of :func:`rows` behind the facts, with their types."""


def rows(variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
    """Rows of a variation's table: its facts, then the columns of :func:`tfra.study.skins.statistics.errors`.

    After them are the ``contacts`` that are there, how many are ``left_out``, since a step misses them, the rates of
    ``KINDS`` at the row's step with their intervals, and the ``reason`` why all of it is null.
    """
    if variation.design is None or scores is None:
        for quantity, step, view in product(SIGNED, variation.compared, View):
            name = {"quantity": quantity, "step": step, "view": view, "reason": variation.reason}
            yield {**variation.facts, **dict.fromkeys(COLUMNS), **name}
        return
    rates: dict[str, dict[str, float]] = {step: {} for step in variation.compared}
    for row in finding(scores, variation.compared, splits=(ALL,)).rows(named=True):
        rates[row["step"]] |= {f"{row['kind']}{end}": row[f"rate{end}"] for end in ("", *INTERVAL)}
    left_out = len(scores) - scores["everywhere"].sum()
    for row in errors(scores, variation.compared).rows(named=True):
        common = {"contacts": len(scores), "left_out": left_out, **rates[row["step"]], "reason": None}
        yield {**variation.facts, **row, **common}
