"""A function for each chart of signals inside the core: from tables to a figure with the numbers of the tables."""

import math
from typing import Any

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLACK, BLUE, VERMILION
from tfra.report.numbers import number
from tfra.study.report.figure import GREY, PALE, ROW_HEIGHT, Rows, add_bars, add_marks, hover_text, rows_figure
from tfra.study.report.labels import Tables

_ERRORS = {"rms_error": "rms", "max_error": "worst", "bias": "bias"}
"""Labels of a stage's errors, by their columns without the unit."""

_LENGTHS = (("word", "bits", PALE, 0.86), ("needed for what was seen", "bits_needed", BLUE, 0.5))
"""Bars of a signal: name, column, colour and width."""


def ranges(tables: Tables) -> go.Figure:
    """Bits that the observed words need, in words of their length, with what the proven bound needs."""
    rows = tables["ranges"].to_dicts()
    lines = Rows.grouped([row["stage"] for row in rows], [row["signal"] for row in rows])
    bits = {"title": {"text": "bits"}, "range": [0, 1.03 * max(row["bits"] for row in rows)], "dtick": 8}
    chart = rows_figure(lines, ROW_HEIGHT, bits, barmode="overlay", bargap=0)
    labelled = [(row, number, _range_text(row)) for row, number in zip(rows, lines.numbers, strict=True)]
    for name, column, colour, width in _LENGTHS:
        points = [(row[column], number) for row, number, _ in labelled]
        add_bars(chart, name, points, [text for *_, text in labelled], width=width, marker={"color": colour})
    tick = {"symbol": "line-ns-open", "size": 7, "color": BLACK, "line": {"width": 2}}
    cross = {"symbol": "x", "size": 8, "color": VERMILION}
    proven = [(_bits_of_bound(row), number, text) for row, number, text in labelled if row["proven"]]
    limited = [(row["bits"], number, text) for row, number, text in labelled if row["saturated"]]
    for name, marks, marker in (("needed for the proven bound", proven, tick), ("some were limited", limited, cross)):
        add_marks(chart, name, [(x, y) for x, y, _ in marks], [text for *_, text in marks], marker=marker)
    return chart


def _bits_of_bound(row: dict[str, Any]) -> int:
    """A signed word has one more negative than positive value."""
    bound = int(row["bound"])
    return (bound - 1).bit_length() + 1 if row["signed"] else bound.bit_length()


def _range_text(row: dict[str, Any]) -> str:
    return hover_text(
        f"{row['signal']} of {row['stage']}",
        f"word: {row['bits']} bits, {'signed' if row['signed'] else 'unsigned'}",
        f"seen: {row['minimum']:,} to {row['maximum']:,}, {row['bits_needed']} bits",
        f"bound: ±{row['bound']:,}{', proven' if row['proven'] else ', the format’s'}",
        f"reached: {number(100 * row['share'])} % of it",
        f"headroom: {row['headroom_bits']} bits",
        "" if row["rounded"] is None else f"rounded: {100 * row['rounded'] / row['words']:.3g} %",
        f"limited: {row['saturated']:,} of {row['words']:,} words",
    )


def stages(tables: Tables) -> go.Figure:
    """SQNR of every signal: from the codes on, and of its stage alone."""
    table = tables["stages"]
    signals = table.select("stage", "signal").unique(maintain_order=True)
    lines = Rows.grouped(signals["stage"].to_list(), signals["signal"].to_list())
    numbers = dict(zip(signals["signal"], lines.numbers, strict=True))
    known = [value for value in table["sqnr_db"] if value is not None]
    low, high = math.floor(min(known, default=0) / 10) * 10 - 5, max(known, default=0) + 12
    axis = {"title": {"text": "signal to rounding error / dB"}, "range": [low, high]}
    chart = rows_figure(lines, ROW_HEIGHT, axis)
    series = {
        "codes": ("from the converter codes on", VERMILION, "diamond"),
        "inputs": ("this stage alone", BLUE, "circle-open"),
    }
    for reference, (name, colour, symbol) in series.items():
        rows = table.filter(reference=reference, exact=False).to_dicts()
        points = [(row["sqnr_db"], numbers[row["signal"]]) for row in rows]
        marker = {"color": colour, "symbol": symbol, "size": 9, "line": {"width": 2, "color": colour}}
        add_marks(chart, name, points, [_stage_text(row, name) for row in rows], marker=marker)
    exact = table.filter("exact").group_by("signal", maintain_order=True).agg(pl.len())
    for signal, references in exact.iter_rows():
        chart.add_annotation(
            x=high, y=numbers[signal], text="exact" if references > 1 else "stage exact",
            showarrow=False, xanchor="right", font={"size": 11, "color": GREY},
        )  # fmt: skip
    return chart


def _stage_text(row: dict[str, Any], name: str) -> str:
    errors = [f"{label} {number(row[f'{key}_lsb'])}" for key, label in _ERRORS.items()]
    return hover_text(
        f"{row['signal']} of {row['stage']}, {name}",
        f"SQNR: {row['sqnr_db']:.1f} dB",
        f"errors in last bits: {', '.join(errors)}",
        f"{row['words']:,} words",
    )
