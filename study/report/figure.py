"""Common parts of all charts: style, logarithmic axes where needed, rows of dots with whiskers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

import plotly.graph_objects as go

from tfra.report.colours import BLACK
from tfra.study.report.words import number

GREY, PALE = "#767676", "#dddddd"

WIDE_SPAN = 30.0
"""Values that span more have a logarithmic axis."""

ROW = 18
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


def figure(height: int, x: dict[str, Any], y: dict[str, Any], **layout: Any) -> go.Figure:
    """An empty figure with these axes; its width is the page's."""
    return go.Figure(layout=_LAYOUT | {"height": height, "xaxis": _AXIS | x, "yaxis": _AXIS | y} | layout)


@dataclass(frozen=True)
class Scale:
    """An axis for values that are not negative: from 0 on, or logarithmic, with zeros at its ``low`` end."""

    log: bool
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float | None]) -> Scale:
        """The axis that shows these values."""
        some = sorted(value for value in values if value)
        if not some or some[-1] <= WIDE_SPAN * some[0]:
            return cls(False, 0.0, 1.05 * some[-1] if some else 1.0)
        return cls(True, some[0] / 2, 1.5 * some[-1])

    def place(self, value: float) -> float:
        """Position of ``value`` on the axis."""
        return max(value, self.low)

    def axis(self, title: str) -> dict[str, Any]:
        """For a figure's layout."""
        shown: dict[str, Any] = {"title": {"text": title}}
        if not self.log:
            return shown | {"range": [self.low, self.high]}
        # A zero stands a little inside.
        ends = [math.log10(self.low) - 0.1, math.log10(self.high)]
        digits = (1, 2, 5) if ends[1] - ends[0] < 2.5 else (1,)
        every = max(1, round((ends[1] - ends[0]) / 6))
        decades = range(math.floor(ends[0]), math.ceil(ends[1]) + 1, every)
        ticks = [d * 10.0**decade for decade in decades for d in digits]
        return shown | {"type": "log", "range": ends, "tickvals": ticks, "ticktext": [number(v, 1) for v in ticks]}


@dataclass(frozen=True)
class Dot:
    """A value in a row, with a whisker from ``start`` to ``end``; ``text`` is seen when one points at it."""

    row: float
    value: float
    start: float
    end: float
    text: str


def add_dots(shown: go.Figure, scale: Scale, name: str, colour: str, symbol: str, dots: Sequence[Dot]) -> None:
    """Add a series of dots; a value of zero on a logarithmic axis is an open triangle at its end."""
    line = {"color": colour, "width": 2}
    whiskers = [place for dot in dots for place in (scale.place(dot.start), scale.place(dot.end), None)]
    rows = [row for dot in dots for row in (dot.row, dot.row, None)]
    shown.add_scatter(x=whiskers, y=rows, mode="lines", line=line, showlegend=False, legendgroup=name, hoverinfo="skip")

    def add(places: Sequence[tuple[float, Dot]], symbol: str, **looks: Any) -> None:
        marker = {"symbol": symbol, "size": 10, "color": colour, "line": line}
        shown.add_scatter(
            x=[scale.place(place) for place, _ in places], y=[dot.row for _, dot in places], mode="markers",
            marker=marker, hovertext=[dot.text for _, dot in places], hoverinfo="text", name=name, legendgroup=name,
            **looks,
        )  # fmt: skip

    caps = [(place, dot) for dot in dots for place in (dot.start, dot.end) if place != dot.value]
    add(caps, "line-ns-open", showlegend=False)
    off = [dot for dot in dots if scale.log and dot.value < scale.low]
    add([(dot.value, dot) for dot in off], "triangle-left-open", showlegend=len(off) == len(dots))
    add([(dot.value, dot) for dot in dots if dot not in off], symbol)


def add_unfit(shown: go.Figure, places: Sequence[tuple[float, float, str]], **looks: Any) -> None:
    """Add a grey cross for each that does not fit together: its x, its y, and the text that says why."""
    if not places:
        return
    x, y, texts = zip(*places, strict=True)
    marker = {"symbol": "x-thin-open", "size": 8, "color": GREY, "line": {"color": GREY, "width": 2}}
    shown.add_scatter(
        x=x, y=y, mode="markers", marker=marker, hovertext=texts, hoverinfo="text", cliponaxis=False,
        **{"name": "does not fit"} | looks,
    )  # fmt: skip


@dataclass(frozen=True)
class Rows:
    """Labelled rows from top to bottom, in groups that have a heading each."""

    labels: tuple[str, ...]
    places: tuple[int, ...]
    """Of the rows that are no headings."""

    @classmethod
    def of(cls, groups: Sequence[str], names: Sequence[str]) -> Rows:
        """The rows ``names``, each of a group."""
        labels: list[str] = []
        places = []
        for n, (group, name) in enumerate(zip(groups, names, strict=True)):
            if not n or group != groups[n - 1]:
                labels.append(f"<b>{group}</b>")
            places.append(len(labels))
            labels.append(name)
        return cls(tuple(labels), tuple(places))

    def axis(self) -> dict[str, Any]:
        """For a figure's layout."""
        ends = [len(self.labels) - 0.4, -0.6]
        return {"range": ends, "tickvals": list(range(len(self.labels))), "ticktext": list(self.labels)} | {
            "ticks": "", "showgrid": False, "tickfont": {"size": 11},
        }  # fmt: skip


def wrapped(text: str) -> str:
    """Words for a hover label, in lines that a narrow window has room for."""
    return "<br>".join(wrap(text, 44))


def say(shown: go.Figure, text: str) -> go.Figure:
    """Write on an empty figure why it is empty."""
    shown.add_annotation(
        text=text, x=0.5, y=0.5, xref="paper", yref="paper", showarrow=False, bgcolor="white",
        font={"size": 13, "color": BLACK},
    )  # fmt: skip
    return shown
