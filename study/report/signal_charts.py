"""A function for each chart of signals inside the core: from tables to a figure with the numbers of the tables."""

import math

import plotly.graph_objects as go
import polars as pl

from tfra.model.fixed.numbers import signed_bits
from tfra.report.colours import BLACK, BLUE, VERMILION
from tfra.report.table import number
from tfra.study.report.figure import GREY, PALE, ROW_HEIGHT, Row, add_marks, grouped, rows_figure, series
from tfra.study.report.labels import Tables

_LENGTHS = (("word", "bits", PALE, 0.86), ("needed for what was seen", "bits_needed", BLUE, 0.5))
"""Bars of a signal: name, column, colour and width."""

_REFERENCES = (
    ("codes", "from the converter codes on", VERMILION, "diamond"),
    ("inputs", "this stage alone", BLUE, "circle-open"),
)
"""Series of a stage's errors: reference, name, colour and symbol."""


def ranges(tables: Tables) -> go.Figure:
    """Bits that the observed words need, in words of their length, with what the proven bound needs."""
    rows = tables["ranges"].to_dicts()
    labels, positions = grouped([row["stage"] for row in rows], [row["signal"] for row in rows])
    at = dict(zip((row["signal"] for row in rows), positions, strict=True))
    bits = {"title": {"text": "bits"}, "range": [0, 1.03 * max(row["bits"] for row in rows)], "dtick": 8}
    chart = rows_figure(labels, ROW_HEIGHT, bits, barmode="overlay", bargap=0)
    for name, column, colour, width in _LENGTHS:
        bars = series(name, rows, [row[column] for row in rows], positions)
        chart.add_bar(
            **bars, orientation="h", width=width, marker={"color": colour, "line": {"color": GREY, "width": 1}}
        )
    tick = {"symbol": "line-ns-open", "size": 7, "color": BLACK, "line": {"width": 2}}
    cross = {"symbol": "x", "size": 8, "color": VERMILION}
    proven, limited = ([row for row in rows if row[name]] for name in ("proven", "saturated"))
    for name, some, lengths, marker in (
        ("needed for the proven bound", proven, map(_bits_of_bound, proven), tick),
        ("some were limited", limited, (row["bits"] for row in limited), cross),
    ):
        add_marks(chart, name, some, list(lengths), [at[row["signal"]] for row in some], marker=marker)
    return chart


def _bits_of_bound(row: Row) -> int:
    """Both signs may reach the bound, as mu_ind does; only a word as long as the converter's ends one code before."""
    bound = row["bound"]
    return min(row["bits"], signed_bits(bound)) if row["signed"] else int(bound).bit_length()


def lengths(tables: Tables) -> go.Figure:
    """Shares of the lengths of coefficients and signals, with the ends of the signals' words."""
    table, words = tables["lengths"], {row["signal"]: row for row in tables["ranges"].to_dicts()}
    names = table.sort("kind", maintain_order=True).select("kind", "name").unique(maintain_order=True).rows()
    labels, positions = grouped([f"{kind}s" for kind, _ in names], [name for _, name in names])
    most = max(table["significant_bits"].max(), *(row["bits"] for row in words.values()))
    at = dict(zip(names, positions, strict=True))
    shares: list[list[float | None]] = [[None] * (most + 1) for _ in labels]
    for position in positions:
        shares[position] = [0.0] * (most + 1)
    for kind, name, bits, share in table.iter_rows():
        shares[at[kind, name]][bits] = share
    axis = {"title": {"text": "bits beside the sign"}, "range": [-0.6, most + 0.6], "dtick": 8}
    chart = rows_figure(labels, ROW_HEIGHT, axis)
    texts = [
        ["" if v is None else f"{label}: {number(100 * v, 2)} % have {bits} bits" for bits, v in enumerate(row)]
        for label, row in zip(labels, shares, strict=True)
    ]
    chart.add_heatmap(
        x=list(range(most + 1)), y=list(range(len(labels))), z=shares, hovertext=texts, hoverinfo="text",
        colorscale="Blues", zmin=0, zmax=0.3, showscale=False, xgap=1, ygap=2, name="share of the words",
    )  # fmt: skip
    ended = [(words[name], position) for (kind, name), position in at.items() if kind == "signal" and name in words]
    ends = [row["bits"] - row["signed"] + 0.5 for row, _ in ended]
    tick = {"symbol": "line-ns-open", "size": 8, "color": VERMILION, "line": {"width": 2}}
    add_marks(chart, "end of the word", [row for row, _ in ended], ends, [y for _, y in ended], marker=tick)
    return chart


def stages(tables: Tables) -> go.Figure:
    """SQNR of every signal: from the codes on, and of its stage alone."""
    table = tables["stages"]
    signals = table.select("stage", "signal").unique(maintain_order=True)
    labels, positions = grouped(signals["stage"].to_list(), signals["signal"].to_list())
    at = dict(zip(signals["signal"], positions, strict=True))
    known = table["sqnr_db"].drop_nulls().to_list()
    low, high = math.floor(min(known, default=0) / 10) * 10 - 5, max(known, default=0) + 12
    chart = rows_figure(labels, ROW_HEIGHT, {"title": {"text": "signal to rounding error / dB"}, "range": [low, high]})
    for reference, name, colour, symbol in _REFERENCES:
        rows = table.filter(reference=reference, exact=False).to_dicts()
        marker = {"color": colour, "symbol": symbol, "size": 9, "line": {"width": 2, "color": colour}}
        ratios = [row["sqnr_db"] for row in rows]
        add_marks(chart, name, rows, ratios, [at[row["signal"]] for row in rows], marker=marker)
    exact = table.filter("exact").group_by("signal", maintain_order=True).agg(pl.len())
    for signal, references in exact.iter_rows():
        chart.add_annotation(
            x=high, y=at[signal], text="exact" if references > 1 else "stage exact",
            showarrow=False, xanchor="right", font={"size": 11, "color": GREY},
        )  # fmt: skip
    return chart
