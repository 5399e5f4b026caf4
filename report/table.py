"""A table once, for pages (HTML), for the guide (Markdown) and for a terminal; numbers as text."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING

from tfra.report.html import grid, row

if TYPE_CHECKING:
    import rich.table

DASH = "–"

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

WIDTH = 100
"""Columns of a table as text."""


def number(value: float, digits: int = 3) -> str:
    """``value`` with so many significant ``digits`` and thousands separators: 1234.5 is 1,230.

    Below 1e-4 it has a power of ten.
    """
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    rounded, magnitude = float(f"{mantissa}e{exponent}") + 0.0, int(exponent)
    if rounded and magnitude < -4:
        return f"{mantissa}×10{str(magnitude).translate(_SUPERSCRIPT)}"
    return f"{rounded:,.{max(0, digits - 1 - magnitude) if rounded else 0}f}"


def cell(value: object) -> str:
    """The text of a table's cell: text as it is, whole numbers in full, others with six digits, a dash for None."""
    match value:
        case None:
            return DASH
        case bool():
            return "yes" if value else "no"
        case int():
            return f"{value:,}"
        case float():
            return f"{value:,.6g}"
    return str(value)


def listed(words: Sequence[str]) -> str:
    """Words as in a sentence: ``a, b and c``."""
    *first, last = words or ("",)
    return f"{', '.join(first)} and {last}" if first else last


@dataclass(frozen=True)
class Table:
    """``rows`` of cells under a ``header``; cells that are no text are formatted by ``cell``.

    ``title`` is printed above the table in a terminal; on a page it is for readers who don't see the table.
    The columns ``words``, counted from 0, hold words and are aligned left; the others hold numbers.
    """

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[object]]
    words: Collection[int] = (0,)

    def html(self) -> str:
        """The table for a page; symbols of the header as :func:`tfra.report.html.text` prints them."""
        rows = (row([cell(value) for value in cells], self.words) for cells in self.rows)
        return grid(self.title, self.header, [rows], self.words)

    def markdown(self) -> str:
        """The table in Markdown, without its title."""
        rule = ["---" if column in self.words else "---:" for column in range(len(self.header))]
        lines = [f"| {' | '.join(self.header)} |", f"|{'|'.join(rule)}|"]
        lines += [f"| {' | '.join(map(cell, cells))} |" for cells in self.rows]
        return "\n".join(lines)

    def rich(self) -> rich.table.Table:
        """The table for a :class:`rich.console.Console`."""
        from rich.table import Column, Table  # slow to load

        columns = (
            Column(name, justify="left" if number in self.words else "right")
            for number, name in enumerate(self.header)
        )
        printed = Table(*columns, title=self.title or None, show_header=any(self.header))
        for cells in self.rows:
            printed.add_row(*map(cell, cells))
        return printed

    def text(self, width: int = WIDTH) -> str:
        """The table as lines of at most ``width`` characters."""
        from rich.console import Console  # slow to load

        file = StringIO()
        Console(file=file, width=width, color_system=None).print(self.rich())
        return file.getvalue()
