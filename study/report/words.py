"""What the tables of a study say, in sentences; every number in them follows from a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import polars as pl

from tfra.model.fixed.design import Design
from tfra.model.tfra import Status
from tfra.study.errors.cascade import Step, View
from tfra.study.frames.block import Part

Tables = Mapping[str, pl.DataFrame]
"""Tables of a study by name; those that are not made, or not yet, are missing."""

CLOSE_PERCENT = 5.0
"""A total that changes by less is as good as the same."""

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SATURATED = [str(status.name).lower() for status in (Status.INPUT_SATURATED, Status.OUTPUT_SATURATED)]


@dataclass(frozen=True)
class Quantity:
    """How a reader knows a quantity: ``label`` and ``unit``; ``error`` says what its error is."""

    label: str
    unit: str
    error: str

    @property
    def axis(self) -> str:
        """The label with its unit."""
        return f"{self.label} / {self.unit}" if self.unit else self.label

    def amount(self, value: float, digits: int = 2) -> str:
        """``value`` with its unit."""
        unit = self.unit.partition(" ")[0]
        return number(value, digits) + ("" if unit in ("", "°") else "\N{NO-BREAK SPACE}") + unit


QUANTITIES = {
    "force_difference_percent_of_true_force": Quantity(
        "F", "% of |F|", "the length of the difference of both resultants, of the true resultant's length"
    ),
    "force_modulus_percent_of_true_force": Quantity(
        "|F|", "% of |F|", "the difference of both resultants' lengths, of the true resultant's length"
    ),
    "phi_deg": Quantity("φ", "°", "the angle between the directions of both tangential forces"),
    "mu": Quantity("μ", "", "the difference of both friction coefficients"),
    "taxel_forces_percent_of_true_taxel_forces": Quantity(
        "field",
        "% of the field",
        "the length of the difference of both vectors of all taxels' forces, of the true one's",
    ),
    "force_x_n": Quantity("F_x", "N", "the difference of both resultants along x"),
    "force_y_n": Quantity("F_y", "N", "the difference of both resultants along y"),
    "force_z_n": Quantity("F_z", "N", "the difference of both resultants along z"),
}
"""Every quantity that has errors, in the order of a reader's interest."""

HEADLINE = {"phi_deg": "", "force_difference_percent_of_true_force": " of F"}
"""What the sentences on top speak of, and what they add to its amount."""

STEPS = {
    Step.METHOD: "the method itself",
    Step.NOISE: "noise and offset",
    Step.CONVERTER: "converter",
    Step.ARITHMETIC: "arithmetic",
}

PARTS = {Part.HELD_OUT: "held-out", Part.TRAIN: "training"}
"""The first that a table has is what sentences speak of."""

STATISTICS = {"p95": "95th percentile", "median": "median"}


def number(value: float, digits: int = 3) -> str:
    """``value`` with so many significant digits and thousands apart; tiny ones with a power of ten."""
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    rounded, magnitude = float(f"{mantissa}e{exponent}") + 0.0, int(exponent)
    if rounded and magnitude < -4:
        return f"{mantissa}×10{str(magnitude).translate(_RAISED)}"
    return f"{rounded:,.{max(0, digits - 1 - magnitude) if rounded else 0}f}"


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(words[:-1]), words[-1]][not words[:-1] :]) if words else ""


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


def cell(table: pl.DataFrame, column: str, **wanted: Any) -> Any:
    """What ``column`` has in the one row with these values; None where there is no such row."""
    found = table.filter(*(pl.col(name) == value for name, value in wanted.items()))[column].to_list()
    return found[0] if found else None


def parts_of(table: pl.DataFrame) -> list[Part]:
    """The parts of frames that a table has, the one to look at first."""
    there = set(table["part"])
    return [part for part in PARTS if part in there]


def answer(tables: Tables, design: Design) -> str:
    """What people come for: each step's share of the error, and which word lengths would do; may be empty."""
    return " ".join(sentence for sentence in (_shares(tables, design), _enough(tables)) if sentence)


def explanation(tables: Tables) -> list[str]:
    """What the numbers of the answer mean, of how many frames they are, and which frames are left out."""
    compared = {"uniform", "sensitivity", "converter", "variants", "trials"} & set(tables)
    where = "Designs, converters and variants are compared on training frames." if compared else ""
    return [sentence for sentence in (_meaning(tables), _left_out(tables), where) if sentence]


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
    return _capital(f"{said}.") if said else ""


def _medians(errors: pl.DataFrame, step: Step, view: View) -> str:
    found = {name: cell(errors, "median", quantity=name, step=step, view=view) for name in HEADLINE}
    return listed([QUANTITIES[n].amount(value) + HEADLINE[n] for n, value in found.items() if value is not None])


def _enough(tables: Tables) -> str:
    """Like ``A 12-bit converter or products of 16×16 bits alone change the total by less than 5 %.``"""
    few, none = [], []
    if "converter" in tables:
        bits, tried = enough_converter(tables["converter"]), tables["converter"]["converter_bits"].to_list()
        few += [f"a {bits}-bit converter"] if bits else []
        none += [] if bits else [f"no converter of {min(tried)} to {max(tried)} bits"]
    if "uniform" in tables and "errors" in tables:
        bits, tried = enough_products(tables), tables["uniform"]["bits"].to_list()
        few += [f"products of {bits}×{bits} bits"] if bits else []
        none += [] if bits else [f"no products of {min(tried)} to {max(tried)} bits"]
    close = f"the total by less than {CLOSE_PERCENT:g}\N{NO-BREAK SPACE}%."
    said = [f"{' or '.join(few)} alone would change {close}"] if few else []
    said += [f"{' and '.join(none)} would change {close}"] if none else []
    return " ".join(map(_capital, said))


def enough_converter(table: pl.DataFrame) -> int | None:
    """The fewest bits from which on no converter, at any noise, changes the total of none by ``CLOSE_PERCENT``."""
    total = table.filter(pl.col("view") == View.TOTAL)
    with_it, without = (total.filter(pl.col("step") == step) for step in (Step.CONVERTER, Step.NOISE))
    return _enough_bits(with_it, without, "converter_bits", ["converter_bits", "noise_share_of_peak", "quantity"])


def enough_products(tables: Tables) -> int | None:
    """The fewest bits from which on no uniform products change the total of float by ``CLOSE_PERCENT``."""
    found = tables["uniform"].filter(pl.col("step") == Step.ARITHMETIC, pl.col("view") == View.TOTAL)
    without = trained(tables["errors"], View.TOTAL).filter(pl.col("step") == Step.CONVERTER)
    return _enough_bits(found, without, "bits", ["quantity"])


def trained(errors: pl.DataFrame, view: View) -> pl.DataFrame:
    """The errors of the frames that designs are compared on."""
    return errors.filter(pl.col("part") == Part.TRAIN, pl.col("view") == view)


def _enough_bits(found: pl.DataFrame, reference: pl.DataFrame, column: str, keys: list[str]) -> int | None:
    """The fewest bits such that from there on every statistic of the headline's quantities is close."""
    pairs = found.filter(pl.col("quantity").is_in(list(HEADLINE))).join(reference, on=keys, suffix="_reference")
    change = [100 * (pl.col(name) / pl.col(f"{name}_reference") - 1).abs() for name in STATISTICS]
    judged = pairs.select(column, close=pl.all_horizontal(*((c < CLOSE_PERCENT).fill_null(False) for c in change)))
    enough = None
    for (bits,), rows in judged.sort(column, descending=True).group_by(column, maintain_order=True):
        if not rows["close"].all():
            break
        enough = bits
    return enough


def _meaning(tables: Tables) -> str:
    if "errors" not in tables:
        return ""
    name, errors = _first_part(tables, "errors")
    of_phi, of_f = (cell(errors, "count", quantity=q, step=Step.ARITHMETIC, view=View.TOTAL) for q in HEADLINE)
    if not of_f:
        return ""
    some = "" if of_phi == of_f else f" (φ: {of_phi:,}, which have friction)"
    close = f"; less than {CLOSE_PERCENT:g}\N{NO-BREAK SPACE}% is meant for median and 95th percentile of both"
    return (
        f"Amounts are medians of the errors' magnitudes over {of_f:,} {name} frames{some}. "
        "The share of a step is what it changes of the result of the step before; all together is the core's result "
        "against the truth. The error of φ is an angle; that of F is the length of the difference of both resultants, "
        f"in percent of the true |F|{close if _enough(tables) else ''}."
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
