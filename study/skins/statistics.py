"""Tables of a skin's contacts, from the rows of all of them: which are found, and the errors of those.

Errors are those of contacts that all steps find, so that steps are compared on the same ones.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import polars as pl

from tfra.model.skin.finding import Mark
from tfra.model.tfra import Status
from tfra.study.errors.cascade import Step, decision_column
from tfra.study.errors.statistics import rate, spreads
from tfra.study.skins.cascade import SIGNED

COUNTS = (1, 2, 3, 5, 9, 17, 65)
"""Limits of the number of contacts in a frame; a group is from one to before the next."""

GAPS = (0.0, 1.0, 2.0, 3.0, 4.0, math.inf)
"""Limits of the gap to the nearest other contact, in pitches."""

ALL, CONTACTS, GAP = "all", "contacts", "gap"
"""How contacts are split."""

ALONE = "alone"
"""The group of contacts without another one in the frame."""

KINDS = ("missed", "merged", "invented")
"""Errors of finding: shares of the contacts that are there, of the same, and of those that are found."""

_GROUP = {"split": pl.String, "group": pl.String}
FINDING = {
    **_GROUP,
    "step": pl.String,
    "kind": pl.String,
    "count": pl.Int64,
    "of": pl.Int64,
    **dict.fromkeys(["rate", "rate_low", "rate_high"], pl.Float64),
}
"""Columns of :func:`finding`."""


def groups(scores: pl.DataFrame) -> Iterator[tuple[str, str, pl.DataFrame]]:
    """Split, name and rows of every group of contacts that is not empty: all, by number in the frame, by gap."""
    yield ALL, ALL, scores
    for least, more in pairwise(COUNTS):
        name = str(least) if more == least + 1 else f"{least}–{more - 1}"
        some = scores.filter(pl.col("contacts").is_between(least, more, closed="left"))
        yield from _unless_empty(CONTACTS, name, some)
    gap = pl.col("gap_pitches")
    for low, high in pairwise(GAPS):
        name = f"{low:g} or more" if high == math.inf else f"{low:g}–{high:g}"
        yield from _unless_empty(GAP, name, scores.filter(gap.is_between(low, high, closed="left")))
    yield from _unless_empty(GAP, ALONE, scores.filter(gap.is_infinite()))


def _unless_empty(split: str, name: str, rows: pl.DataFrame) -> Iterator[tuple[str, str, pl.DataFrame]]:
    if len(rows):
        yield split, name, rows


def errors(scores: pl.DataFrame, compared: Sequence[Step] = tuple(Step)) -> pl.DataFrame:
    """Return a row each quantity, step ``compared`` and view, as :func:`tfra.study.errors.statistics.errors` does."""
    return spreads(scores, SIGNED, compared)


def by_group(scores: pl.DataFrame) -> pl.DataFrame:
    """Return the same behind the ``split`` and its ``group``, for all groups but that of all contacts."""
    parts = [
        errors(rows).select(pl.lit(split).alias("split"), pl.lit(name).alias("group"), pl.all())
        for split, name, rows in groups(scores)
        if split != ALL
    ]
    return pl.concat(parts)


def finding(
    scores: pl.DataFrame, compared: Sequence[Step] = tuple(Step), splits: Sequence[str] = (ALL, CONTACTS, GAP)
) -> pl.DataFrame:
    """Return a row each group, step ``compared`` and kind of error: how many of how many, with the Wilson interval.

    Those that are invented have no gap to others.
    """
    rows = [
        {"split": split, "group": name, "step": step, "kind": kind, "count": count, "of": of} | rate(count, of)
        for split, name, part in groups(scores)
        if split in splits
        for step in compared
        for kind, count, of in _counts(part, step)
        if kind != "invented" or split != GAP
    ]
    return pl.DataFrame(rows, schema=FINDING)


def _counts(part: pl.DataFrame, step: Step) -> Iterator[tuple[str, int, int]]:
    """Every kind: how many of how many."""
    total = {name: int(part[decision_column(name, step)].sum()) for name in (*KINDS, "seen")}
    for kind in KINDS:
        yield kind, total[kind], total["seen"] if kind == "invented" else len(part)


def marked(scores: pl.DataFrame) -> pl.DataFrame:
    """Return how many of the contacts that each step finds have each bit of the status, marks included."""
    rows: list[dict[str, Any]] = []
    for step in Step:
        found = scores.filter(~pl.col(decision_column("missed", step)))
        status = found[decision_column("status", step)].to_numpy()
        bits = [(str(bit.name), int(((status & bit.value) != 0).sum())) for bit in (*Status, *Mark)]
        rows += [{"step": step, "status": name.lower(), "contacts": n, "of": len(found)} for name, n in bits if n]
    schema = {"step": pl.String, "status": pl.String, "contacts": pl.Int64, "of": pl.Int64}
    return pl.DataFrame(rows, schema=schema)
