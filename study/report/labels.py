"""Labels of what the tables of a study contain: quantities, steps, statistics, settings, costs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import polars as pl

from tfra.report.table import cell, number
from tfra.study.errors.cascade import Step
from tfra.study.frames.block import Part
from tfra.study.search.evaluate import CHANGE

Tables = Mapping[str, pl.DataFrame]
"""Tables of a study by name; those that are not made, or not yet, are missing."""

CLOSE_PERCENT = 5.0
"""A total that changes by less is as good as the same."""

CLOSE = f"{CLOSE_PERCENT:g}\N{NO-BREAK SPACE}%"
"""The same as text."""

HELD_OUT, SYNTHESISED, PLACED = "_held_out", "synthesised_", "placed_"
"""Suffix of a quantity's name, and prefixes of a cost's name, in the table of designs."""


@dataclass(frozen=True)
class Quantity:
    """Label and unit of a quantity."""

    label: str
    unit: str

    @property
    def axis(self) -> str:
        """The label with its unit."""
        return f"{self.label} / {self.unit}" if self.unit else self.label

    def amount(self, value: float, digits: int = 2) -> str:
        """``value`` with its unit."""
        unit = self.unit.partition(" ")[0]
        return number(value, digits) + ("" if unit in ("", "°") else "\N{NO-BREAK SPACE}") + unit


QUANTITIES = {
    "force_difference_percent_of_true_force": Quantity("F", "% of |F|"),
    "force_modulus_percent_of_true_force": Quantity("|F|", "% of |F|"),
    "phi_deg": Quantity("φ", "°"),
    "mu": Quantity("μ", ""),
    "taxel_forces_percent_of_true_taxel_forces": Quantity("field", "% of the field"),
    "force_x_n": Quantity("F_x", "N"),
    "force_y_n": Quantity("F_y", "N"),
    "force_z_n": Quantity("F_z", "N"),
    "place_pitches": Quantity("place", "pitches"),
}
"""Every quantity that has errors, in the order of a reader's interest."""

STEPS = {
    Step.METHOD: "the method itself",
    Step.NOISE: "noise and offset",
    Step.CONVERTER: "converter",
    Step.ARITHMETIC: "arithmetic",
}

PARTS = {Part.HELD_OUT: "held-out", Part.TRAIN: "training"}
"""Sentences are about the first that a table has."""

STATISTICS = {"p95": "95th percentile", "median": "median"}

VARIANTS = {
    "steps": ("steps", "steps K of the sweep"),
    "plateau_tolerance": ("plateau_tolerance_lsb", "plateau tolerance / LSB"),
    "rounding": ("rounding", "rounding of products"),
}
"""Variations other than word lengths: the column of the setting, and its label."""

_WITH_INTERVAL = ("median", "p95", "p99_9", "rate", "missed", "merged", "invented")

_COLUMNS = {
    "coefficient_kbit": "coefficients / kbit",
    "multiplier_kbit": "products / kbit",
    "latency_cycles": "latency / cycles",
    "interval_cycles": "interval / cycles",
    "dsp": "DSP",
    "fmax_mhz": "f_max / MHz",
    "p95": "95th percentile",
    "p99_9": "99.9th percentile",
    **dict.fromkeys([f"{name}_low" for name in _WITH_INTERVAL], "95 % confidence, from"),
    **dict.fromkeys([f"{name}_high" for name in _WITH_INTERVAL], "to"),
    "p95_change": "change of the 95th percentile / %",
    "median_change": "change of the median / %",
    "of": "of frames",
    "sqnr_db": "SQNR / dB",
    "max_error_lsb": "worst / LSB",
    "rms_error_lsb": "rms / LSB",
    "bias_lsb": "bias / LSB",
    "noise_share_of_peak": "noise, share of the peak",
    "plateau_tolerance_lsb": "plateau tolerance / LSB",
    "sweep_index_equal": "share of frames with float’s sweep index",
    "within": f"within {CLOSE} of float’s total",
    "rtl_frames": "frames in RTL",
    "rtl_words": "words in RTL",
    "rtl_differ": "words that differ",
}
"""Labels of columns; others keep their names."""


def column_label(column: str) -> str:
    """The label of a column; of a quantity's name, it is that of the 95th percentile of the error."""
    name = column.removesuffix(HELD_OUT)
    part = "" if column == name else ", held-out frames"
    if name in QUANTITIES:
        return f"95th percentile of the error of {QUANTITIES[name].axis}{part}"
    if name == CHANGE:
        return f"growth of the total error over float’s / %{part}"
    for prefix in (SYNTHESISED, PLACED):
        if column.startswith(prefix):
            return f"{column.removeprefix(prefix)}, {prefix.removesuffix('_')}"
    return _COLUMNS.get(column, column.replace("_", " "))


def cell_text(column: str, value: Any) -> str:
    """The text of a cell of a table."""
    return QUANTITIES[value].axis if column == "quantity" else cell(value)


def cost_amount(cost: str, value: float) -> str:
    """Cost of a design, with its unit: whole numbers in full, others with at least three digits."""
    whole = len(f"{value:.0f}")
    digits = whole if value == round(value) else max(3, whole)
    label, _, unit = column_label(cost).partition(" / ")
    return f"{number(value, digits)}\N{NO-BREAK SPACE}{f'{unit} of {label}' if unit else label}"


def setting(value: float | str) -> str:
    """The setting of a variant."""
    return value.replace("_", " ") if isinstance(value, str) else f"{value:g}"
