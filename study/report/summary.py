"""Conclusions from the tables of a study, in sentences; every number in them follows from a table."""

from collections.abc import Mapping
from itertools import product
from typing import Any

import polars as pl

from tfra.model.fixed.design import Design
from tfra.report.table import listed, number
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import BEYOND, PERMILLES
from tfra.study.frames.block import Part
from tfra.study.report.labels import (
    CLOSE,
    CLOSE_PERCENT,
    PARTS,
    PLACED,
    QUANTITIES,
    STATISTICS,
    STEPS,
    SYNTHESISED,
    Tables,
    cost_amount,
)
from tfra.study.search.costs import COSTS
from tfra.study.search.evaluate import CHANGE
from tfra.study.search.trials import COMPLETE

HEADLINE = {"phi_deg": "", "force_difference_percent_of_true_force": " of F"}
"""Quantities of the first sentences, and the text after their value."""

_COST = "coefficient_kbit"

RESOURCES = ("LUT", "FF", "DSP", "BRAM")
"""Resources that designs are compared in."""

WORTH_PERCENT = 20.0
"""A mixed design that saves less of a measured resource is not worth its trouble."""

_TOTAL = {"step": Step.ARITHMETIC, "view": View.TOTAL}

_COMPARED = {"uniform", "sensitivity", "converter", "variants", "trials"}

_MEANING = (
    "Amounts are medians of the errors' magnitudes over {part} frames; φ has none without friction. The share of a "
    "step is its change of the result of the step before; all together is the error of the core's result against the "
    "ground truth. The error of φ is an angle; that of F is the length of the difference vector in percent of the true "
    f"|F|. A change by less than {CLOSE} is one of both the median and the 95th percentile of both errors."
)


_NEXT = {
    Step.METHOD: "the method errs most, so more bits gain little: choose contacts that suit it, another estimator, or "
    "one that is trained longer",
    Step.NOISE: "noise and offset err most, so more bits gain little: lower them, or average frames",
    Step.CONVERTER: "the converter errs most: take one with more bits, or a smaller full scale",
    Step.ARITHMETIC: "arithmetic errs most: lengthen the words of the signals that need their bits",
}
"""What to do about the step with the largest share of the error."""


def summary(tables: Tables, design: Design) -> list[str]:
    """Lines: what was asked, what limits the accuracy, which lengths are enough, what they save, what to do next.

    Where designs were synthesised, a line tells what a mixed design saves of a resource.

    Those that the tables do not answer yet are missing.
    """
    answers = {
        "Limit": shares(tables, design),
        "Enough": sufficient(tables),
        "Saved": _smallest_design(tables),
        "Measured": _measured(tables),
        "Next": advice(tables),
    }
    lines = [f"{name}: {words}" for name, words in answers.items() if words]
    sensor = design.sensor
    asked = (
        f"Asked: how many bits does `{design.name}` need ({sensor.rows}×{sensor.columns} taxels, {design.adc.bits}-bit "
        f"converter, arithmetic `{design.formats.name}`), if its error may change by {CLOSE}?"
    )
    return [asked, *lines] if lines else []


def notes(tables: Tables) -> list[str]:
    """Meaning of the summary's numbers, and which frames they leave out."""
    sentences = []
    if "errors" in tables:
        part, errors = first_part(tables, "errors")
        sentences += [_MEANING.format(part=part), _enough_frames(errors)]
    if "flagged" in tables:
        sentences.append(_left_out(*first_part(tables, "flagged")))
    if _COMPARED & set(tables):
        sentences.append("Designs, converters and variants are compared on training frames.")
    return sentences


def first_part(tables: Tables, name: str) -> tuple[str, pl.DataFrame]:
    """Return the label and the rows of the part that sentences are about."""
    part = next(part for part in PARTS if part in set(tables[name]["part"]))
    return PARTS[part], tables[name].filter(part=part)


def shares(tables: Tables, design: Design) -> str:
    """Return ``the method itself, 4.0° and 18 % of F; ...`` or so: medians of what each step adds, largest first."""
    if "errors" not in tables:
        return ""
    _, errors = first_part(tables, "errors")
    labels = STEPS | {
        Step.CONVERTER: f"{design.adc.bits}-bit converter",
        Step.ARITHMETIC: f"arithmetic `{design.formats.name}`",
    }
    medians = {labels[step]: _medians(errors.filter(step=step, view=View.OWN)) for step in _by_share(errors)}
    medians["all together"] = _medians(errors.filter(**_TOTAL))
    known = "; ".join(f"{name}, {share}" for name, share in medians.items() if share)
    return f"{known}." if known else "there are too few frames to split the error into steps."


def _by_share(errors: pl.DataFrame) -> list[Step]:
    """The steps whose share of the error of F is known, the largest first."""
    own = errors.filter(quantity=list(HEADLINE)[-1], view=View.OWN).drop_nulls("median")
    return list(map(Step, own.sort("median", descending=True, maintain_order=True)["step"]))


def advice(tables: Tables) -> str:
    """Return what to do with the design that was found, and about the step with the largest share."""
    words = []
    if (name := _best(_judged_designs(tables))) not in (None, "base"):
        words.append(f"generate the core of `designs/{name}.toml`")
    if "errors" in tables:
        words += [_NEXT[step] for step in _by_share(first_part(tables, "errors")[1])[:1]]
    return f"{'; '.join(words)}." if words else ""


def _medians(errors: pl.DataFrame) -> str:
    """The known medians of the headline's quantities, which have a row each."""
    medians = dict(errors.drop_nulls("median").select("quantity", "median").iter_rows())
    return listed([QUANTITIES[name].amount(medians[name]) + of for name, of in HEADLINE.items() if name in medians])


def sufficient(tables: Tables) -> str:
    """Return ``a 12-bit converter or products of 16×16 bits alone would change the total by less than 5 %.`` or so."""
    some, none = [], []
    for name, fewest, few, too_few in (
        ("converter", sufficient_converter_bits, "a {0}-bit converter", "no converter of {0} to {1} bits"),
        ("uniform", sufficient_product_bits, "products of {0}×{0} bits", "no products of {0} to {1} bits"),
    ):
        if lengths := _judged_lengths(tables, name):
            bits = fewest(tables)
            some += [few.format(bits)] if bits else []
            none += [] if bits else [too_few.format(min(lengths), max(lengths))]
    close = f"would change the total by less than {CLOSE}"
    sentences = [f"{' or '.join(some)} alone {close}"] if some else []
    sentences += [f"{' and '.join(none)} {close}"] if none else []
    return f"{'; '.join(sentences)}." if sentences else ""


def _judged_lengths(tables: Tables, name: str) -> list[int]:
    """Lengths whose totals have all statistics; none where there are too few frames, or no errors to compare with."""
    if name not in tables or (name == "uniform" and "errors" not in tables):
        return []
    total = tables[name].filter(pl.col("quantity").is_in(list(HEADLINE)), view=View.TOTAL)
    known = pl.all_horizontal(pl.col(name).is_not_null() for name in STATISTICS)
    return total.group_by("bits").agg(known=known.all()).filter("known")["bits"].to_list()


def sufficient_converter_bits(tables: Tables) -> int | None:
    """The fewest bits from which on no converter, at any noise, changes the total of none by ``CLOSE_PERCENT``."""
    with_it, without = (tables["converter"].filter(step=s, view=View.TOTAL) for s in (Step.CONVERTER, Step.NOISE))
    return _sufficient_bits(with_it, without, ["bits", "noise_share_of_peak", "quantity"])


def sufficient_product_bits(tables: Tables) -> int | None:
    """The fewest bits from which on no uniform products change the total of float by ``CLOSE_PERCENT``."""
    without = tables["errors"].filter(part=Part.TRAIN, step=Step.CONVERTER, view=View.TOTAL)
    return _sufficient_bits(tables["uniform"].filter(**_TOTAL), without, ["quantity"])


def _sufficient_bits(errors: pl.DataFrame, reference: pl.DataFrame, keys: list[str]) -> int | None:
    """The fewest bits such that from there on every statistic of the headline's quantities is close.

    Lengths that do not fit do not count.
    """
    fit = errors.filter(pl.col("reason").is_null(), pl.col("quantity").is_in(list(HEADLINE)))
    pairs = fit.join(reference, on=keys, suffix="_reference")
    change = [100 * (pl.col(name) / pl.col(f"{name}_reference") - 1).abs() for name in STATISTICS]
    close = pl.all_horizontal(*((each < CLOSE_PERCENT).fill_null(False) for each in change))
    fewest = None
    for bits, fits in pairs.group_by("bits").agg(close=close.all()).sort("bits", descending=True).iter_rows():
        if not fits:
            break
        fewest = bits
    return fewest


def _enough_frames(errors: pl.DataFrame) -> str:
    """How many frames the errors are of, and how many percentiles take."""
    counts = errors.filter(pl.col("quantity").is_in(list(HEADLINE)), **_TOTAL).select("quantity", "count")
    frames = listed([f"{count:,} valid frames for {QUANTITIES[name].label}" for name, count in counts.iter_rows()])
    median, p95 = (BEYOND * 1000 // (1000 - PERMILLES[name]) for name in ("median", "p95"))
    return f"There are {frames}: a median needs {median}, a 95th percentile {p95}; unknown values are left out."


def _left_out(part: str, flagged: pl.DataFrame) -> str:
    """How many frames have no errors, and for which flags."""
    left_out, of = flagged.filter(status="left_out").select("frames", "of").row(0)
    flags = flagged.filter(pl.col("status") != "left_out").group_by("status", maintain_order=True).agg(pl.max("frames"))
    most = [f"{name.replace('_', ' ')} in {frames:,}" for name, frames in flags.iter_rows() if frames]
    by_step = f" (most at any one step: {listed(most)})" if most else ""
    return (
        f"{left_out:,} of {of:,} {part} frames are left out of all errors, since a step flags them; frames that "
        f"saturate are kept{by_step}."
    )


def _smallest_design(tables: Tables) -> str:
    """Like ``the smallest design within 5 % of float's total is `mixed` (199 kbit of coefficients, ...).``"""
    judged = _judged_designs(tables)
    if not judged:
        return ""
    if not (name := _best(judged)):
        return f"nothing; no design of the table is within {CLOSE} of float's total."
    cost, _ = judged[name]
    others = {"uniform": "the best uniform one, `uniform`", "base": "that of CONFIG, `base`"}
    beside = {other: judged[other][0] for other in others if other in judged and other != name}
    less = [f"{_difference(cost, value)} than {others[other]}" for other, value in beside.items()]
    amount = f"{cost_amount(_COST, cost)}{', ' if less else ''}{listed(less)}"
    return f"the smallest design within {CLOSE} of float's total is `{name}` ({amount})."


def _measured(tables: Tables) -> str:
    """Like ``by synthesis, `mixed` takes 23 % less LUT than `uniform`; estimates are off by up to 4 % (LUT).``"""
    table = tables.get("designs", pl.DataFrame())
    prefix = PLACED if f"{PLACED}LUT" in table.columns else SYNTHESISED
    resources = [name for name in RESOURCES if prefix + name in table.columns]
    rows = table.drop_nulls([prefix + name for name in resources]).to_dicts() if resources else []
    if not (rows and _judged_designs(tables)):
        return ""
    errors = listed([f"{_percent(_most_off(rows, prefix, name))} ({name})" for name in resources])
    how = {PLACED: "placed and routed", SYNTHESISED: "by synthesis"}[prefix]
    return f"{how}, {_most_saved(rows, prefix, resources)}estimates are off by up to {errors}."


def _most_saved(rows: list[dict[str, Any]], prefix: str, resources: list[str]) -> str:
    """The resource of which a mixed design saves most; empty without one of both."""
    uniform = next((row for row in rows if row["name"] == "uniform"), None)
    mixed = [row for row in rows if row["within"] and row["name"] not in ("uniform", "base")]
    if not (uniform and mixed):
        return ""
    shares = {
        (row["name"], name): 100 * (1 - row[prefix + name] / uniform[prefix + name])
        for row, name in product(mixed, resources)
        if uniform[prefix + name]
    }
    (design, resource), most = max(shares.items(), key=lambda item: item[1])
    if most < WORTH_PERCENT:
        worth = f"{_percent(WORTH_PERCENT)} less of a resource than `uniform`"
        return f"no mixed design takes {worth}: most is {_percent(most)} of {resource}; "
    return f"`{design}` takes {_percent(most)} less {resource} than `uniform`; "


def _most_off(rows: list[dict[str, Any]], prefix: str, name: str) -> float:
    """The largest error of the estimates of a resource, in percent."""
    return max(float(100 * abs(row[name] - row[prefix + name]) / max(row[prefix + name], 1)) for row in rows)


def _percent(value: float) -> str:
    return f"{number(value, 2)}\N{NO-BREAK SPACE}%"


def _judged_designs(tables: Tables) -> dict[str, tuple[float, bool]]:
    """The cost of each design with a judgement, and whether it is close to float, the cheapest first."""
    if "designs" not in tables:
        return {}
    known = tables["designs"].drop_nulls(["within", _COST]).sort(_COST, maintain_order=True)
    return {name: (cost, bool(within)) for name, cost, within in known.select("name", _COST, "within").iter_rows()}


def _best(judged: Mapping[str, tuple[float, bool]]) -> str | None:
    return next((name for name, (_, within) in judged.items() if within), None)


def _difference(value: float, other: float) -> str:
    percent = 100 * (value / other - 1)
    return f"{_percent(abs(percent))} {'less' if percent < 0 else 'more'}"


def costs_of(tables: Tables) -> list[str]:
    """The costs that trials have, in the table's order."""
    return [name for name in tables["trials"].columns if name in COSTS] if "trials" in tables else []


def cheapest_trials(tables: Tables) -> dict[tuple[str, ...], str]:
    """A sentence for each cost: its least within the tolerance by the search, and by random choice."""
    searches = {"trials": "", "baseline": "by random choice: "}
    start = f"Cheapest within {CLOSE} of float's errors: "
    return {
        (cost,): start + "; ".join(searches[n] + _cheapest(tables[n], cost) for n in searches if n in tables) + "."
        for cost in costs_of(tables)
    }


def _cheapest(trials: pl.DataFrame, cost: str) -> str:
    close = trials.filter(pl.col(CHANGE) <= CLOSE_PERCENT, state=COMPLETE).sort(cost, "number")
    if close.is_empty():
        return f"none of {len(trials):,} trials"
    least, trial = close.select(cost, "number").row(0)
    return f"{cost_amount(cost, least)} (trial {trial:,} of {len(trials):,})"
