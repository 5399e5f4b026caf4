"""Words for the contents of tables: quantities, steps, costs, numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import polars as pl

from tfra.study.errors.cascade import Step, View
from tfra.study.frames.block import Part

Tables = Mapping[str, pl.DataFrame]
"""Tables of a study by name; those that are not made, or not yet, are missing."""

CLOSE_PERCENT = 5.0
"""A total that changes by less is as good as the same."""

CLOSE = f"{CLOSE_PERCENT:g}\N{NO-BREAK SPACE}%"
"""The same as text."""

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Quantity:
    """Texts of a quantity for readers: ``label`` and ``unit``; ``error`` describes its error."""

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
        "F", "% of |F|", "the length of the difference of both resultants, relative to the true resultant's length"
    ),
    "force_modulus_percent_of_true_force": Quantity(
        "|F|", "% of |F|", "the difference of both resultants' lengths, relative to the true resultant's length"
    ),
    "phi_deg": Quantity("φ", "°", "the angle between the directions of both tangential forces"),
    "mu": Quantity("μ", "", "the difference of both friction coefficients"),
    "taxel_forces_percent_of_true_taxel_forces": Quantity(
        "field",
        "% of the field",
        "the length of the difference of both vectors of all taxels' forces, relative to the true vector's",
    ),
    "force_x_n": Quantity("F_x", "N", "the difference of both resultants along x"),
    "force_y_n": Quantity("F_y", "N", "the difference of both resultants along y"),
    "force_z_n": Quantity("F_z", "N", "the difference of both resultants along z"),
}
"""Every quantity that has errors, in the order of a reader's interest."""

STEPS = {
    Step.METHOD: "the method itself",
    Step.NOISE: "noise and offset",
    Step.CONVERTER: "converter",
    Step.ARITHMETIC: "arithmetic",
}

PARTS = {Part.HELD_OUT: "held-out", Part.TRAIN: "training"}
"""The first that a table has is what sentences speak of."""

STATISTICS = {"p95": "95th percentile", "median": "median"}

VARIANTS = {
    "steps": ("steps", "steps K of the sweep"),
    "plateau_tolerance": ("plateau_tolerance_lsb", "plateau tolerance / LSB"),
    "rounding": ("rounding", "rounding of products"),
}
"""Variations other than word lengths: the column of the setting, and its label."""

COST_UNITS = {
    "coefficient_kbit": "kbit of coefficients",
    "latency_cycles": "cycles of latency",
    "interval_cycles": "cycles from frame to frame",
    "dsp": "DSP",
}
"""Unit after the number of a cost; other costs are their own units."""


def number(value: float, digits: int = 3) -> str:
    """``value`` with a number of significant digits and a thousands separator; tiny ones with a power of ten."""
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    rounded, magnitude = float(f"{mantissa}e{exponent}") + 0.0, int(exponent)
    if rounded and magnitude < -4:
        return f"{mantissa}×10{str(magnitude).translate(_RAISED)}"
    return f"{rounded:,.{max(0, digits - 1 - magnitude) if rounded else 0}f}"


def listed(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(words[:-1]), words[-1]][not words[:-1] :]) if words else ""


def cell(table: pl.DataFrame, column: str, **wanted: Any) -> Any:
    """What ``column`` has in the one row with these values; None where there is no such row."""
    found = table.filter(*(pl.col(name) == value for name, value in wanted.items()))[column].to_list()
    return found[0] if found else None


def parts_of(table: pl.DataFrame) -> list[Part]:
    """The parts of frames that a table has, the one to look at first."""
    there = set(table["part"])
    return [part for part in PARTS if part in there]


def taken(value: float) -> str:
    """A number of resources: whole numbers in full, others with at least three digits."""
    whole = len(f"{value:.0f}")
    return number(value, whole if value == round(value) else max(3, whole))


def amount(cost: str, value: float) -> str:
    """Cost of a design, with its unit."""
    return f"{taken(value)}\N{NO-BREAK SPACE}{COST_UNITS.get(cost, cost)}"


def setting(value: float | str) -> str:
    """The setting of a variant."""
    return value.replace("_", " ") if isinstance(value, str) else f"{value:g}"


def trained(errors: pl.DataFrame, view: View) -> pl.DataFrame:
    """The errors of the frames that designs are compared on."""
    return errors.filter(pl.col("part") == Part.TRAIN, pl.col("view") == view)
