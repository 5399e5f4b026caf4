"""The data, the style and the files of a figure; the files have the same bytes in every run."""

import csv
import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from tfra.report.colours import STRESS

STYLE: Any = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "legend.framealpha": 0.9,
    "lines.markersize": 4,
    "figure.dpi": 100,
    "savefig.dpi": 160,  # of the parts that are pixels
    "svg.hashsalt": "tfra",
    "svg.fonttype": "path",
}

STRESS_MAP = LinearSegmentedColormap.from_list("stress", STRESS)

Column = npt.NDArray[Any]
Columns = dict[str, Column]
"""Named columns of equal length; units are part of the names."""


@dataclass(frozen=True)
class Text:
    """Notes for judging a figure or table, each a short paragraph."""

    published: str
    measured: str
    why: str


@dataclass(frozen=True)
class Picture:
    """A figure, its numbers and its notes; ``name`` begins the names of its files."""

    name: str
    title: str
    columns: Columns
    figure: Figure
    text: Text


@contextmanager
def looks() -> Iterator[None]:
    """Draw in this project's style, whatever the user's matplotlibrc says."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        yield


def stacked(parts: Mapping[str, Columns]) -> Columns:
    """The columns of all contacts one below the other, with their keys in front."""
    lengths = [len(next(iter(columns.values()))) for columns in parts.values()]
    names = next(iter(parts.values()))
    return {"contact": np.repeat(list(parts), lengths)} | {
        name: np.concatenate([columns[name] for columns in parts.values()]) for name in names
    }


def legend_below(figure: Figure, axes: Axes, columns: int = 0) -> None:
    """One legend for all panels, that of ``axes``, below them in so many columns; 0: in one line."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns or len(labels))


def write(picture: Picture, folder: Path) -> None:
    """Write NAME.csv and NAME.svg into ``folder``."""
    (folder / f"{picture.name}.csv").write_text(to_csv(picture.columns), encoding="utf-8")
    picture.figure.savefig(folder / f"{picture.name}.svg", metadata={"Date": None})


def rounded(columns: Columns) -> Columns:
    """The numbers as rounded in the CSV file, for drawing, because the last bits depend on the number of threads."""
    floats = {name: np.array([float(_cell(v)) for v in c]) for name, c in columns.items() if c.dtype.kind == "f"}
    return columns | floats


def to_csv(columns: Mapping[str, Column]) -> str:
    """``columns`` as CSV with a header; six significant digits.  Raises ``ValueError`` for unequal lengths."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return stream.getvalue()


def _cell(value: Any) -> str:
    return f"{value + 0.0:.6g}" if isinstance(value, float | np.floating) else str(value)
