"""Tables of errors and of decisions that flip, from the rows of all frames.

Frames that any step flags, except for saturation, are left out of all steps: estimates of a frame without contact or
without traction cannot be compared.  :func:`flagged` counts them.  Quantiles are those of all values, so the division
into blocks does not matter; a million frames take some 300 MB.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np
import polars as pl
from scipy import stats

from tfra.model.arrays import Floats
from tfra.model.tfra import OF_CORES, Status
from tfra.study.errors.cascade import SIGNED, Step, View, decision_column, error_column

PERMILLES = {"median": 500, "p95": 950, "p99_9": 999}
"""Percentiles of a table, by their columns."""

BEYOND = 10
"""Least number of values beyond a percentile; with fewer it depends on single frames, and is null."""

CONFIDENCE = 0.95
"""Of the intervals of percentiles and rates."""

INTERVAL = ("_low", "_high")
"""Ends of an interval, behind the name of its column."""

_SATURATION = Status.INPUT_SATURATED | Status.OUTPUT_SATURATED

ERRORS = {
    "quantity": pl.String,
    "step": pl.String,
    "view": pl.String,
    "count": pl.Int64,
    **dict.fromkeys([*(f"{name}{end}" for name in PERMILLES for end in ("", *INTERVAL)), "worst"], pl.Float64),
    "worst_frame": pl.Int64,
    "bias": pl.Float64,
}
"""Columns of :func:`errors`."""

_COMPARED = ("quadrant", "sweep_y", "negative", "sweep_index")
"""Decisions of unflagged frames; an estimator that sweeps nothing has the first one alone."""

_FLIPS = {
    "step": pl.String,
    "decision": pl.String,
    "frames": pl.Int64,
    "of": pl.Int64,
    **dict.fromkeys(["rate", "rate_low", "rate_high"], pl.Float64),
}


def unflagged(scores: pl.DataFrame) -> pl.Series:
    """Return which rows no step flags, except for saturation."""
    clean = (pl.col(decision_column("status", step)) & ~int(_SATURATION) == 0 for step in Step)
    return scores.select(unflagged=pl.all_horizontal(*clean)).to_series()


def errors(scores: pl.DataFrame, compared: Sequence[Step] = tuple(Step)) -> pl.DataFrame:
    """Return a row each quantity, step ``compared`` and view of unflagged frames, in the quantity's unit.

    Median, 95th and 99.9th percentile and worst are of magnitudes, each percentile with the values at the ends of its
    interval, by the binomial distribution of how many others are below it.  ``worst_frame`` is the number of the first
    frame that has the worst.  ``bias`` is the mean with its sign, null where there is none.  ``count`` leaves out
    frames whose error is unknown or undefined, such as that of phi without friction.
    """
    return spreads(scores.filter(unflagged(scores)), SIGNED, compared)


def spreads(scores: pl.DataFrame, quantities: Mapping[str, bool], compared: Sequence[Step]) -> pl.DataFrame:
    """Return the same of all ``scores``, for ``quantities`` and whether the error of each has a sign."""
    frames = scores["frame"].to_numpy()
    rows = [
        {"quantity": key, "step": step, "view": view}
        | _spread(scores[error_column(key, step, view)].to_numpy(), frames, signed)
        for key, signed in quantities.items()
        for step in compared
        for view in View
    ]
    return pl.DataFrame(rows, schema=ERRORS)


def _spread(values: Floats, frames: Floats, signed: bool) -> dict[str, Any]:
    """Return the columns of a row of errors that follow the view, from ``values (n,)`` and the ``frames`` of each."""
    known = np.flatnonzero(~np.isnan(values))
    exact = values[known].astype(np.float64)
    found: dict[str, Any] = {"count": len(exact)}
    magnitudes = np.abs(exact)
    for column, permille in PERMILLES.items():
        if len(exact) * (1000 - permille) >= BEYOND * 1000:
            found[column] = float(np.quantile(magnitudes, permille / 1000))
            low, high = map(int, stats.binom.interval(CONFIDENCE, len(exact), permille / 1000))
            ends = np.partition(magnitudes, (low - 1, high))[[low - 1, high]]
            found |= {f"{column}{end}": float(value) for end, value in zip(INTERVAL, ends, strict=True)}
    if len(exact):
        worst = magnitudes.argmax()
        found |= {"worst": float(magnitudes[worst]), "worst_frame": int(frames[known[worst]])}
        found["bias"] = float(exact.mean()) if signed else None
    return found


def flagged(scores: pl.DataFrame) -> pl.DataFrame:
    """Return how many of all frames have each status bit at each step; in the last row, how many are left out."""
    bits = {step: scores[decision_column("status", step)].to_numpy() for step in Step}
    rows = [
        (str(step), str(status.name).lower(), int(np.count_nonzero(bits[step] & status.value)), len(scores))
        for step, status in product(Step, Status)
        if status in OF_CORES or any((of & status.value).any() for of in bits.values())
    ]
    rows += [("any", "left_out", int((~unflagged(scores)).sum()), len(scores))]
    schema = {"step": pl.String, "status": pl.String, "frames": pl.Int64, "of": pl.Int64}
    return pl.DataFrame(rows, schema, orient="row")


def flips(scores: pl.DataFrame) -> pl.DataFrame:
    """Return how often a step's decision differs from that of the step before, with Wilson intervals of 95 %
    confidence.

    ``status`` without saturation is compared in all frames; the others in unflagged ones.  Indices are compared where
    the same variable is swept the same way: ``of`` says how many frames these are.  A rate of no frames is null.
    """
    used = scores.filter(unflagged(scores))
    rows = [
        {"step": step, "decision": decision, "frames": count, "of": total} | rate(count, total)
        for before, step in pairwise(Step)
        for decision, count, total in _changes(scores, used, before, step)
    ]
    return pl.DataFrame(rows, schema=_FLIPS)


def index_equal_rate(scores: pl.DataFrame) -> float | None:
    """Return the rate of ``sweep_index_equal`` of the arithmetic alone, null of no frames, and where none is swept."""
    changes = _changes(scores, scores.filter(unflagged(scores)), Step.CONVERTER, Step.ARITHMETIC)
    counts = ((count, total) for decision, count, total in changes if decision == "sweep_index_equal")
    count, total = next(counts, (0, 0))
    return count / total if total else None


def _changes(scores: pl.DataFrame, used: pl.DataFrame, before: Step, step: Step) -> Iterator[tuple[str, int, int]]:
    """Every decision: its name, in how many frames it changes, and of how many."""
    one, other = (scores[decision_column("status", each)].to_numpy() & ~_SATURATION.value for each in (before, step))
    yield "status", int((one != other).sum()), len(scores)
    first, then = (
        {key: used[name].to_numpy() for key in _COMPARED if (name := decision_column(key, each)) in used.columns}
        for each in (before, step)
    )
    for decision, key in (("quadrant", "quadrant"), ("swept_variable", "sweep_y")):
        if key in first:
            yield decision, int((first[key] != then[key]).sum()), len(used)
    if "sweep_index" not in first:
        return
    same = (first["sweep_y"] == then["sweep_y"]) & (first["negative"] == then["negative"])
    moved = np.abs(then["sweep_index"] - first["sweep_index"])[same]
    yield "sweep_index_equal", int((moved == 0).sum()), len(moved)
    yield "sweep_index_off_by_one", int((moved == 1).sum()), len(moved)
    yield "sweep_index_off_by_more", int((moved > 1).sum()), len(moved)


def rate(count: int, total: int) -> dict[str, float]:
    """Return ``count`` of ``total`` as a rate with its interval; nothing of none."""
    if not total:
        return {}
    interval = stats.binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return {"rate": count / total, "rate_low": float(interval.low), "rate_high": float(interval.high)}
