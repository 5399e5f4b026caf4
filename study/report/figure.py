"""Common parts of all charts: style, axes that are logarithmic where needed, rows of dots with whiskers."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import plotly.graph_objects as go

from tfra.report.colours import BLACK
from tfra.report.table import number
from tfra.study.errors.statistics import INTERVAL
from tfra.study.report.labels import cell_text, column_label

GREY, PALE = "#767676", "#dddddd"

WIDE_SPAN = 30.0
"""Values that span more have a logarithmic axis."""

ROW_HEIGHT = 18
"""Height of a signal's row, in pixels."""

_LAYOUT: dict[str, Any] = {
    "template": "none",
    "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#111"},
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
    "margin": {"l": 8, "r": 14, "t": 34, "b": 45},
    "legend": {"orientation": "h", "x": 0, "xref": "container", "y": 1, "yref": "container", "yanchor": "top"},
    "hoverlabel": {"bgcolor": "white", "bordercolor": GREY, "font": {"size": 12, "color": "#111"}, "align": "left"},
    "hovermode": "closest",
}
_AXIS: dict[str, Any] = {
    "gridcolor": PALE,
    "zerolinecolor": GREY,
    "linecolor": GREY,
    "ticks": "outside",
    "tickcolor": GREY,
    "automargin": True,
    "showline": True,
    "zeroline": False,
}

Row = Mapping[str, Any]
"""Of a table, by column."""


def figure(height: int, x: dict[str, Any], y: dict[str, Any], **layout: Any) -> go.Figure:
    """An empty figure with these axes; its width is the page's."""
    return go.Figure(layout=_LAYOUT | {"height": height, "xaxis": _AXIS | x, "yaxis": _AXIS | y} | layout)


def rows_figure(labels: Sequence[str], height: int, x: dict[str, Any], **layout: Any) -> go.Figure:
    """An empty figure of labelled rows from top to bottom, so many pixels each."""
    y = {"range": [len(labels) - 0.4, -0.6], "showgrid": False, "tickfont": {"size": 11}} | ticks(labels)
    return figure(len(labels) * height + 95, x, y, **layout)


def ticks(labels: Sequence[str]) -> dict[str, Any]:
    """For an axis whose positions 0, 1 and so on have these labels."""
    return {"tickvals": list(range(len(labels))), "ticktext": list(labels), "ticks": ""}


def grouped(groups: Sequence[str], names: Sequence[str]) -> tuple[list[str], list[int]]:
    """Labels of the rows ``names`` with a heading above each of their groups, and the positions of the names."""
    labels: list[str] = []
    positions = []
    for n, (group, name) in enumerate(zip(groups, names, strict=True)):
        if not n or group != groups[n - 1]:
            labels.append(f"<b>{group}</b>")
        positions.append(len(labels))
        labels.append(name)
    return labels, positions


@dataclass(frozen=True)
class Scale:
    """An axis for values that are not negative: from 0 on, or logarithmic, with zeros at its ``low`` end."""

    log: bool
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float | None]) -> "Scale":
        """The axis for these values."""
        some = sorted(value for value in values if value)
        if not some or some[-1] <= WIDE_SPAN * some[0]:
            return cls(False, 0.0, 1.05 * some[-1] if some else 1.0)
        return cls(True, some[0] / 2, 1.5 * some[-1])

    def clip(self, value: float) -> float:
        """Position of ``value`` on the axis."""
        return max(value, self.low)

    def hides(self, value: float) -> bool:
        """Whether ``value`` is a zero that a logarithmic axis cannot have."""
        return self.log and value < self.low

    def axis(self, title: str) -> dict[str, Any]:
        """For a figure's layout."""
        axis: dict[str, Any] = {"title": {"text": title}}
        if not self.log:
            return axis | {"range": [self.low, self.high]}
        # A zero stands a little inside.
        ends = [math.log10(self.low) - 0.1, math.log10(self.high)]
        digits = (1, 2, 5) if ends[1] - ends[0] < 2.5 else (1,)
        every = max(1, round((ends[1] - ends[0]) / 6))
        decades = range(math.floor(ends[0]), math.ceil(ends[1]) + 1, every)
        ticks = [d * 10.0**decade for decade in decades for d in digits]
        return axis | {"type": "log", "range": ends, "tickvals": ticks, "ticktext": [number(v, 1) for v in ticks]}


def hover_text(title: str, row: Row) -> str:
    """A title over all known cells of a row, in lines that fit into a narrow window, few enough for a low chart.

    An interval stands behind its value.
    """
    known = {name: value for name, value in row.items() if value not in (None, "")}
    cells = (
        f"{column_label(name)}: {cell_text(name, value)}"
        + (f" ({interval(row, name)})" if name + INTERVAL[0] in known else "")
        for name, value in known.items()
        if not name.endswith(INTERVAL)
    )
    return "<br>".join([f"<b>{title}</b>", *wrap("; ".join(cells), 50)])


def interval(row: Row, column: str, digits: int = 2) -> str:
    """The interval of a column's value."""
    return " to ".join(number(row[f"{column}{end}"], digits) for end in INTERVAL)


def series(name: str, rows: Sequence[Row], x: Sequence[float], y: Sequence[float]) -> dict[str, Any]:
    """A series of a figure whose points show their ``rows`` on hover."""
    texts = [hover_text(name, row) for row in rows]
    return {"name": name, "x": x, "y": y, "hovertext": texts, "hoverinfo": "text"}


def add_marks(
    chart: go.Figure, name: str, rows: Sequence[Row], x: Sequence[float], y: Sequence[float], **looks: Any
) -> None:
    """Add a series of markers, unless it is empty."""
    if rows:
        chart.add_scatter(**series(name, rows, x, y) | {"mode": "markers"} | looks)


@dataclass(frozen=True)
class Style:
    """Look of a series of dots."""

    name: str
    colour: str
    symbol: str


def add_dots(
    chart: go.Figure, scale: Scale, style: Style, points: Iterable[tuple[float, Row]], value: str, low: str, high: str
) -> None:
    """Add dots at the position and with the row of each of ``points``; three columns are the value and its whisker.

    A value of zero on a logarithmic axis is an open triangle at its end.
    """
    last = sorted(points, key=lambda point: scale.hides(point[1][value]))  # so that the legend has the symbol
    rows = [row for _, row in last]
    x, start, end = ([scale.clip(row[value] if row[n] is None else row[n]) for row in rows] for n in (value, low, high))
    add_marks(
        chart, style.name, rows, x, [position for position, _ in last],
        marker={
            "symbol": ["triangle-left-open" if scale.hides(row[value]) else style.symbol for row in rows],
            "size": 10,
            "color": style.colour,
            "line": {"color": style.colour, "width": 2},
        },
        error_x={
            "array": [right - at for right, at in zip(end, x, strict=True)],
            "arrayminus": [at - left for left, at in zip(start, x, strict=True)],
            "thickness": 2,
            "color": style.colour,
        },
    )  # fmt: skip


def add_misfits(chart: go.Figure, rows: Sequence[Row], x: Sequence[float], y: Sequence[float], **looks: Any) -> None:
    """Add a grey cross for each variation that does not fit together; its row says why."""
    marker = {"symbol": "x-thin-open", "size": 8, "color": GREY, "line": {"color": GREY, "width": 2}}
    add_marks(chart, "does not fit", rows, x, y, marker=marker, cliponaxis=False, **looks)


def is_misfit(row: Row) -> bool:
    """Whether a variation has no numbers, since its choices do not fit together."""
    return row.get("reason") is not None


def unless_empty(chart: go.Figure, filled: bool, reason: str) -> go.Figure:
    """The ``chart``, with the ``reason`` on it where it is not ``filled``."""
    if not filled:
        centre = {"x": 0.5, "y": 0.5, "xref": "paper", "yref": "paper", "showarrow": False}
        chart.add_annotation(text=reason, bgcolor="white", font={"size": 13, "color": BLACK}, **centre)
    return chart
