"""Conclusions from the tables of a study, in sentences; every number in them follows from a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import polars as pl

from tfra.model.fixed.design import Design
from tfra.model.tfra import Status
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import BEYOND, PERMILLES
from tfra.study.report.found import errors_of, smallest
from tfra.study.report.words import (
    CLOSE,
    CLOSE_PERCENT,
    PARTS,
    QUANTITIES,
    STATISTICS,
    STEPS,
    VARIANTS,
    Tables,
    cell,
    listed,
    parts_of,
    setting,
    trained,
)

HEADLINE = {"phi_deg": "", "force_difference_percent_of_true_force": " of F"}
"""Quantities of the first sentences, and the text after their value."""

_SATURATED = [str(status.name).lower() for status in (Status.INPUT_SATURATED, Status.OUTPUT_SATURATED)]


def answer(tables: Tables, design: Design) -> str:
    """The answer: each step's share of the error, and sufficient word lengths; may be empty."""
    return " ".join(sentence for sentence in (_shares(tables, design), _enough(tables), smallest(tables)) if sentence)


def explanation(tables: Tables) -> list[str]:
    """Meaning of the answer's numbers, number of frames, and frames that are left out."""
    compared = {"uniform", "sensitivity", "converter", "variants", "trials"} & set(tables)
    where = "Designs, converters and variants are compared on training frames." if compared else ""
    said = _meaning(tables), _within(tables), _too_few(tables), _left_out(tables), where
    return [sentence for sentence in said if sentence]


def _first_part(tables: Tables, name: str) -> tuple[str, pl.DataFrame]:
    part = parts_of(tables[name])[0]
    return PARTS[part], tables[name].filter(pl.col("part") == part)


def _shares(tables: Tables, design: Design) -> str:
    """Like ``14-bit converter: 0.6° and 1.0 % of F; ...``: medians of what each step adds."""
    if "errors" not in tables:
        return ""
    _, errors = _first_part(tables, "errors")
    named = {Step.CONVERTER: f"{design.adc.bits}-bit converter", Step.ARITHMETIC: f"arithmetic `{design.formats.name}`"}
    order = Step.CONVERTER, Step.ARITHMETIC, Step.NOISE, Step.METHOD
    shares = {(STEPS | named)[step]: _medians(errors, step, View.OWN) for step in order}
    shares["all together"] = _medians(errors, Step.ARITHMETIC, View.TOTAL)
    said = "; ".join(f"{name}: {share}" for name, share in shares.items() if share)
    return _capital(f"{said}." if said else "there are too few frames to split the error into steps.")


def _medians(errors: pl.DataFrame, step: Step, view: View) -> str:
    found = {name: cell(errors, "median", quantity=name, step=step, view=view) for name in HEADLINE}
    return listed([QUANTITIES[n].amount(value) + HEADLINE[n] for n, value in found.items() if value is not None])


def _enough(tables: Tables) -> str:
    """Like ``A 12-bit converter or products of 16×16 bits alone change the total by less than 5 %.``"""
    few, none = [], []
    if "converter" in tables and (tried := _tried(tables["converter"])):
        bits = enough_converter(tables["converter"])
        few += [f"a {bits}-bit converter"] if bits else []
        none += [] if bits else [f"no converter of {min(tried)} to {max(tried)} bits"]
    if "uniform" in tables and "errors" in tables and (tried := _tried(tables["uniform"])):
        bits = enough_products(tables)
        few += [f"products of {bits}×{bits} bits"] if bits else []
        none += [] if bits else [f"no products of {min(tried)} to {max(tried)} bits"]
    close = f"the total by less than {CLOSE}."
    said = [f"{' or '.join(few)} alone would change {close}"] if few else []
    said += [f"{' and '.join(none)} would change {close}"] if none else []
    return " ".join(map(_capital, said))


def _tried(table: pl.DataFrame) -> list[int]:
    """Lengths of which all statistics of the headline's totals are known; none where frames are too few to judge."""
    total = table.filter(pl.col("quantity").is_in(list(HEADLINE)), pl.col("view") == View.TOTAL)
    known = pl.all_horizontal(pl.col(name).is_not_null() for name in STATISTICS)
    return total.group_by("bits").agg(known=known.all()).filter("known")["bits"].to_list()


def enough_converter(table: pl.DataFrame) -> int | None:
    """The fewest bits from which on no converter, at any noise, changes the total of none by ``CLOSE_PERCENT``."""
    total = table.filter(pl.col("view") == View.TOTAL)
    with_it, without = (total.filter(pl.col("step") == step) for step in (Step.CONVERTER, Step.NOISE))
    return _enough_bits(with_it, without, ["bits", "noise_share_of_peak", "quantity"])


def enough_products(tables: Tables) -> int | None:
    """The fewest bits from which on no uniform products change the total of float by ``CLOSE_PERCENT``."""
    found = tables["uniform"].filter(pl.col("step") == Step.ARITHMETIC, pl.col("view") == View.TOTAL)
    without = trained(tables["errors"], View.TOTAL).filter(pl.col("step") == Step.CONVERTER)
    return _enough_bits(found, without, ["quantity"])


def _enough_bits(found: pl.DataFrame, reference: pl.DataFrame, keys: list[str]) -> int | None:
    """The fewest bits such that from there on every statistic of the headline's quantities is close.

    Lengths that do not fit do not count.
    """
    fit = found.filter(pl.col("reason").is_null(), pl.col("quantity").is_in(list(HEADLINE)))
    pairs = fit.join(reference, on=keys, suffix="_reference")
    change = [100 * (pl.col(name) / pl.col(f"{name}_reference") - 1).abs() for name in STATISTICS]
    judged = pairs.select("bits", close=pl.all_horizontal(*((c < CLOSE_PERCENT).fill_null(False) for c in change)))
    enough = None
    for (bits,), rows in judged.sort("bits", descending=True).group_by("bits", maintain_order=True):
        if not rows["close"].all():
            break
        enough = bits
    return enough


def unfit(tables: Tables, name: str) -> str:
    """Which rows of a table of variations have no numbers, and why."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in tables[name].filter(pl.col("reason").is_not_null()).iter_rows(named=True):
        subject, value = varied(name, row)
        values = found.setdefault((subject, row["reason"].rpartition(", got ")[0] or row["reason"]), [])
        values += [] if value in values else [value]
    said = [f"{subject}{listed(values)} ({reason})" for (subject, reason), values in found.items()]
    return f"Impossible, hence without numbers: {'; '.join(said)}." if said else ""


def varied(name: str, row: Mapping[str, Any]) -> tuple[str, str]:
    """What a row of the table ``name`` varies, and its value."""
    if name == "variants":
        column, label = VARIANTS[row["variant"]]
        return f"{label}: ", setting(row[column])
    return f"`{row['signal']}` of " if name == "sensitivity" else "", f"{row['bits']} bits"


def _meaning(tables: Tables) -> str:
    if "errors" not in tables:
        return ""
    name, errors = _first_part(tables, "errors")
    of_phi, of_f = (cell(errors, "count", quantity=q, step=Step.ARITHMETIC, view=View.TOTAL) for q in HEADLINE)
    if not _medians(errors, Step.ARITHMETIC, View.TOTAL):
        return ""
    some = "" if of_phi == of_f else f" (φ: {of_phi:,}, which have friction)"
    close = f"; less than {CLOSE} holds for the median and the 95th percentile of both"
    return (
        f"Amounts are medians of the errors' magnitudes over {of_f:,} {name} frames{some}. "
        "The share of a step is its change of the result of the step before; all together is the error of the core's "
        "result against the ground truth. The error of φ is an angle; that of F is the length of the difference vector "
        f"in percent of the true |F|{close if _enough(tables) else ''}."
    )


def _within(tables: Tables) -> str:
    """Quantities that a design is judged by."""
    if not smallest(tables):
        return ""
    of = listed([QUANTITIES[name].label for name in errors_of(tables["designs"])])
    return (
        f"A design is within {CLOSE} of float's total if, on held-out frames, the 95th percentile of its total error "
        f"in {of} exceeds that of float arithmetic on the same codes by no more."
    )


def _too_few(tables: Tables) -> str:
    """Of which errors percentiles are unknown, and how many frames they take."""
    if "errors" not in tables:
        return ""
    least = {name: BEYOND * 1000 // (1000 - PERMILLES[name]) for name in STATISTICS}
    unknown = pl.any_horizontal(pl.col(name).is_null() for name in STATISTICS)
    last = pl.col("step") == Step.ARITHMETIC, pl.col("view") == View.TOTAL, pl.col("quantity").is_in(list(HEADLINE))
    rows = tables["errors"].filter(unknown, *last).select("count", "part", "quantity").rows()
    there = listed([f"{count:,} {PARTS[part]} frames for {QUANTITIES[name].label}" for count, part, name in rows])
    return (
        f"There are too few frames for all numbers: a median needs {least['median']} valid frames, a 95th percentile "
        f"{least['p95']}; there are {there}. Unknown values are left out."
        if rows
        else ""
    )


def _left_out(tables: Tables) -> str:
    """How many frames have no errors, and for which flags."""
    if "flagged" not in tables:
        return ""
    name, flagged = _first_part(tables, "flagged")
    out, of = flagged.filter(pl.col("status") == "left_out").select("frames", "of").row(0)
    most = flagged.filter(pl.col("status") != "left_out").group_by("status", maintain_order=True).max()
    flags = {status: frames for status, frames in most.select("status", "frames").iter_rows() if frames}
    said_of = {status: f"{status.replace('_', ' ')} in {frames:,}" for status, frames in flags.items()}
    why = listed([said for status, said in said_of.items() if status not in _SATURATED])
    kept = listed([said for status, said in said_of.items() if status in _SATURATED])
    flagged_by = f", since a step flags them (at any one step at most: {why})" if why else ""
    said = f"{out:,} of {of:,} {name} frames are left out of all errors{flagged_by}"
    said = said if out else f"None of {of:,} {name} frames is left out"
    return said + (f"; frames that saturate are kept ({kept})." if kept else ".")


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]
