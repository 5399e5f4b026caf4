"""Common parts of all charts: style, axes that are logarithmic where needed, rows of dots with whiskers."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import plotly.graph_objects as go

from tfra.report.colours import BLACK
from tfra.report.numbers import number

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

Point = tuple[float | None, float | None]
"""Position across and up; a line breaks at one that is unknown."""


def figure(height: int, x: dict[str, Any], y: dict[str, Any], **layout: Any) -> go.Figure:
    """An empty figure with these axes; its width is the page's."""
    return go.Figure(layout=_LAYOUT | {"height": height, "xaxis": _AXIS | x, "yaxis": _AXIS | y} | layout)


def rows_figure(lines: "Rows", height: int, x: dict[str, Any], **layout: Any) -> go.Figure:
    """An empty figure of labelled rows, so many pixels each."""
    return figure(len(lines.labels) * height + 95, x, lines.axis(), **layout)


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


@dataclass(frozen=True)
class Rows:
    """Labelled rows from top to bottom, in groups that have a heading each."""

    labels: tuple[str, ...]
    numbers: tuple[int, ...]
    """Of the rows that are no headings."""

    @classmethod
    def plain(cls, names: Sequence[str]) -> "Rows":
        """The rows ``names`` without headings."""
        return cls(tuple(names), tuple(range(len(names))))

    @classmethod
    def grouped(cls, groups: Sequence[str], names: Sequence[str]) -> "Rows":
        """The rows ``names``, each of a group."""
        labels: list[str] = []
        numbers = []
        for n, (group, name) in enumerate(zip(groups, names, strict=True)):
            if not n or group != groups[n - 1]:
                labels.append(f"<b>{group}</b>")
            numbers.append(len(labels))
            labels.append(name)
        return cls(tuple(labels), tuple(numbers))

    def axis(self) -> dict[str, Any]:
        """For a figure's layout."""
        ticks = {"tickvals": list(range(len(self.labels))), "ticktext": list(self.labels), "ticks": ""}
        return {"range": [len(self.labels) - 0.4, -0.6], **ticks, "showgrid": False, "tickfont": {"size": 11}}


def add_marks(chart: go.Figure, name: str, points: Sequence[Point], texts: str | Sequence[str], **looks: Any) -> None:
    """Add a series of markers with texts on hover, unless it is empty."""
    if points:
        x, y = zip(*points, strict=True)
        chart.add_scatter(x=x, y=y, name=name, hovertext=texts, hoverinfo="text", **{"mode": "markers"} | looks)


def add_bars(chart: go.Figure, name: str, points: Sequence[Point], texts: Sequence[str], **looks: Any) -> None:
    """Add horizontal bars up to ``points`` with texts on hover."""
    x, y = zip(*points, strict=True) if points else ((), ())
    chart.add_bar(x=x, y=y, name=name, orientation="h", hovertext=texts, hoverinfo="text", **looks)


@dataclass(frozen=True)
class Dot:
    """A value in a row, with a whisker from ``low`` to ``high``; ``text`` is seen on hover."""

    row: float
    value: float
    low: float
    high: float
    text: str


def add_dots(chart: go.Figure, scale: Scale, name: str, colour: str, symbol: str, dots: Sequence[Dot]) -> None:
    """Add a series of dots; a value of zero on a logarithmic axis is an open triangle at its end."""
    line = {"color": colour, "width": 2}
    zeros = [dot for dot in dots if scale.log and dot.value < scale.low]
    others = [dot for dot in dots if dot not in zeros]
    for some, shape in ((zeros, "triangle-left-open"), (others, symbol)):
        points = [(scale.clip(dot.value), dot.row) for dot in some]
        whiskers = {
            "array": [scale.clip(dot.high) - scale.clip(dot.value) for dot in some],
            "arrayminus": [scale.clip(dot.value) - scale.clip(dot.low) for dot in some],
            "thickness": 2,
        }
        add_marks(
            chart, name, points, [dot.text for dot in some], legendgroup=name, showlegend=some is others or not others,
            marker={"symbol": shape, "size": 10, "color": colour, "line": line}, error_x=whiskers,
        )  # fmt: skip


def add_misfits(chart: go.Figure, points: Sequence[Point], texts: Sequence[str], **looks: Any) -> None:
    """Add a grey cross for each variation that does not fit together; its text says why."""
    marker = {"symbol": "x-thin-open", "size": 8, "color": GREY, "line": {"color": GREY, "width": 2}}
    add_marks(chart, "does not fit", points, texts, marker=marker, cliponaxis=False, **looks)


def misfit_text(row: Mapping[str, Any]) -> str:
    """Why the variation of a row has no numbers, in lines that fit into a narrow window."""
    return hover_text("does not fit", wrapped(row["reason"]))


def hover_text(title: str, *lines: str) -> str:
    """A bold title, and the ``lines`` that are not empty."""
    return "<br>".join([f"<b>{title}</b>", *filter(None, lines)])


def wrapped(text: str) -> str:
    """Words for a hover label, in lines that fit into a narrow window."""
    return "<br>".join(wrap(text, 44))


def unless_empty(chart: go.Figure, filled: bool, reason: str) -> go.Figure:
    """The ``chart``, with the ``reason`` on it where it is not ``filled``."""
    if not filled:
        centre = {"x": 0.5, "y": 0.5, "xref": "paper", "yref": "paper", "showarrow": False}
        chart.add_annotation(text=reason, bgcolor="white", font={"size": 13, "color": BLACK}, **centre)
    return chart
