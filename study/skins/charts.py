"""The charts of a skin's page that no other study has."""

from collections.abc import Sequence

import plotly.graph_objects as go
import polars as pl

from tfra.report.colours import BLUE, GREEN, PURPLE, VERMILION
from tfra.study.errors.cascade import Step, View
from tfra.study.errors.statistics import INTERVAL
from tfra.study.report.error_charts import dots
from tfra.study.report.figure import Row, Style, grouped
from tfra.study.report.labels import QUANTITIES, STEPS, Tables
from tfra.study.skins.statistics import ALL, CONTACTS, GAP, KINDS

SPLITS = {CONTACTS: "contacts in the frame", GAP: "gap to the nearest / pitches"}

_KINDS = {
    "missed": Style("missed", VERMILION, "diamond"),
    "merged": Style("merged", PURPLE, "square"),
    "invented": Style("invented", BLUE, "circle"),
}

_STEPS = {
    Step.METHOD: Style(STEPS[Step.METHOD], GREEN, "square"),
    Step.NOISE: Style(STEPS[Step.NOISE], PURPLE, "circle"),
    Step.CONVERTER: Style(STEPS[Step.CONVERTER], BLUE, "triangle-up"),
    Step.ARITHMETIC: Style("all together", VERMILION, "diamond"),
}

_RATES = ("rate", "rate_low", "rate_high")


def finding(tables: Tables, part: str) -> go.Figure:
    """The rates of all contacts after each step."""
    rows = tables["finding"].filter(split=ALL, part=part).to_dicts()
    points = [(KINDS.index(row["kind"]), row) for row in rows]
    return dots(points, list(KINDS), 76, "share of contacts", _RATES, "step", _STEPS)


def finding_by_group(tables: Tables, part: str) -> go.Figure:
    """The rates of the core in each group."""
    rows = tables["finding"].filter(pl.col("split") != ALL, part=part, step=Step.ARITHMETIC).to_dicts()
    points, labels = _grouped(rows)
    return dots(points, labels, 40, "share of contacts", _RATES, "kind", _KINDS)


def groups(tables: Tables, quantity: str, part: str) -> go.Figure:
    """Errors of the method and of the core in each group."""
    table = tables["groups"].filter(quantity=quantity, part=part, view=View.TOTAL)
    rows = table.filter(pl.col("step").is_in([Step.METHOD, Step.ARITHMETIC])).to_dicts()
    points, labels = _grouped(rows)
    title = f"error of {QUANTITIES[quantity].axis}"
    return dots(points, labels, 34, title, ("median", "median", "p95"), "step", _STEPS)


def converter_finding(tables: Tables) -> go.Figure:
    """The rates after every converter and noise."""
    of_one = pl.col("quantity") == tables["converter"]["quantity"][0]
    rows = tables["converter"].filter(of_one, step=Step.CONVERTER, view=View.TOTAL).to_dicts()
    noises = [f"noise of {100 * row['noise_share_of_peak']:g} % of the peak" for row in rows]
    labels, positions = grouped(noises, [f"{row['bits']} bits" for row in rows])
    points = [(at, _rate(row, kind)) for at, row in zip(positions, rows, strict=True) for kind in KINDS]
    return dots(points, labels, 30, "share of contacts", _RATES, "kind", _KINDS)


def _rate(row: Row, kind: str) -> Row:
    """The rate of a kind in a row of a comparison, as a row of the table of findings has it."""
    rates = {f"rate{end}": row[f"{kind}{end}"] for end in ("", *INTERVAL)}
    return {"kind": kind, "contacts": row["contacts"], "reason": row["reason"]} | rates


def _grouped(rows: Sequence[Row]) -> tuple[list[tuple[int, Row]], list[str]]:
    """Each row with the position of its group, and the labels of all positions."""
    distinct = list(dict.fromkeys((row["split"], row["group"]) for row in rows))
    labels, positions = grouped([SPLITS[split] for split, _ in distinct], [name for _, name in distinct])
    at = dict(zip(distinct, positions, strict=True))
    return [(at[row["split"], row["group"]], row) for row in rows], labels
