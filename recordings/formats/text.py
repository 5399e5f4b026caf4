"""Reading a recording from text: one frame a line, with detection of the separator."""

import codecs
import csv
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.formats import Columns, Format, Values, finite
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import opened

Line = tuple[int, list[str]]
"""Its number in the file, from 1, and its cells."""

_SEPARATORS = (",", ";", "\t", "|", " ")
"""In the order in which they are tried; a blank stands for any number of blanks and tabs."""

_ROWS = 10_000
"""Rows that are written at a time."""

_LIKE_A_TIME = 4
"""Most cells beyond the taxels that may be other columns."""


@dataclass(frozen=True)
class Table:
    """How the lines of ``file`` are read: ``skip`` cells, then a number for every taxel."""

    file: Path
    sensor: SensorArray
    skip: int
    separator: str

    @property
    def width(self) -> int:
        """Cells of a line."""
        return self.skip + self.sensor.taxels

    def split(self, line: str) -> list[str]:
        """The cells of ``line`` as they are written."""
        return line.split(None if self.separator == " " else self.separator)

    def cells(self, line: str) -> list[str]:
        """The cells of ``line``, with points in their numbers; a separator at its end has none after it."""
        cells = self.split(line)
        cells = [cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell for cell in cells]
        if len(cells) == self.width + 1 and not cells[-1].strip():
            del cells[-1]
        return cells

    def fits(self, line: str) -> bool:
        """Whether ``line`` is as many numbers as there are taxels, after the cells that are skipped."""
        cells = self.cells(line)
        return len(cells) == self.width and all(map(_is_number, cells[self.skip :]))


def read(file: Path, sensor: SensorArray, given: Input) -> Values:
    """Return the lines of the text ``file``, ``(n, m)``, without the cells that are skipped, of which the first is the
    time, ``(n,)``, if all of them are finite numbers, else None.  A number too large for a double is infinite.

    Separators are commas, semicolons, tabs, bars or blanks, whichever makes the first lines fit the taxels; but between
    commas a decimal comma will do.  A first line of headings, empty lines and those that begin with # are left out.
    Raises ``InputError`` naming the line.
    """
    skip, every = given.skip_columns, enumerate(_text(file), 1)
    texts = [(number, line) for number, line in every if line.strip() and not line.lstrip().startswith("#")]
    table = table_for(file, sensor, skip, [line for _, line in texts[:2]])
    if texts and are_headings(table.cells(texts[0][1])):
        del texts[0]
    lines = require_numbers(table, texts)
    if lines and [cell.strip() for cell in lines[0][1][skip:]] == [str(taxel) for taxel in range(sensor.taxels)]:
        reason = f"the numbers from 0 to {sensor.taxels - 1} are headings, not stress: remove the line"
        raise InputError(file, f"line {lines[0][0]}", reason)
    values = np.empty((len(lines), sensor.taxels))
    for row, (_, cells) in zip(values, lines, strict=True):
        row[:] = [float(cell) for cell in cells[skip:]]
    return Values(values, _times([cells[0] for _, cells in lines]) if skip else None)


def require_numbers(table: Table, texts: list[tuple[int, str]]) -> list[Line]:
    """Return the lines with their cells; raises ``InputError`` naming the first that is not a frame."""
    _require_one_point(table, texts)
    lines = [(number, table.cells(line)) for number, line in texts]
    for line in lines:
        _require_numbers(table, line, lines)
    return lines


def table_for(file: Path, sensor: SensorArray, skip: int, first: list[str]) -> Table:
    """Return the table that the first lines of text fit; if they fit none, the one with the most helpful error."""
    tables = [Table(file, sensor, skip, separator) for separator in _SEPARATORS]
    fitting = [table for table in tables if any(map(table.fits, first))]

    def numbers(table: Table) -> int:
        return sum(_is_number(cell) for line in first for cell in table.cells(line))

    return fitting[0] if fitting else max(tables, key=numbers)


def _times(cells: list[str]) -> Floats | None:
    return finite(np.array(cells, dtype=np.float64)) if all(map(_is_number, cells)) else None


def _text(file: Path) -> list[str]:
    """Return the lines of ``file``, with any line ends."""
    with opened(file) as stream:
        data = stream.read()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(file, "", "is UTF-16 text, UTF-8 is needed")
    try:
        lines = re.split("\r\n|\r|\n", data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise InputError(file, "", "is not UTF-8 text") from None
    for number, line in enumerate(lines, 1):
        if "\0" in line:
            raise InputError(file, f"line {number}", "a NUL byte is in the text")
    return lines


def are_headings(cells: list[str]) -> bool:
    """Headings are names: empty or starting with a letter, an underscore, a quote or #; a typo starts with none."""
    names = [cell.strip() for cell in cells]
    return not any(map(_is_number, names)) and all(
        not name or name[0].isalpha() or name[0] in "_\"'#" for name in names
    )


def _require_one_point(table: Table, texts: list[tuple[int, str]]) -> None:
    """Numbers with points in one place and commas in another may have the commas between thousands."""
    if table.separator == ",":
        return
    first: dict[str, int] = {}
    for number, line in texts:
        for mark in re.findall("(?<=[0-9])[.,](?=[0-9])", " ".join(table.split(line)[table.skip :])):
            first.setdefault(mark, number)
    if len(first) == 2:
        (other, _), (here, number) = first.items()
        names = {".": "points", ",": "commas"}
        reason = f"this line has decimal {names[here]}, others have decimal {names[other]}"
        raise InputError(table.file, f"line {number}", reason)


def _require_numbers(table: Table, line: Line, lines: list[Line]) -> None:
    number, cells = line
    if len(cells) != table.width:
        sensor, skip = table.sensor, f" after {table.skip} skipped column{'s' * (table.skip > 1)}" if table.skip else ""
        needed = f"{sensor.taxels} numbers ({sensor.rows} rows x {sensor.columns} columns){skip} are needed"
        hint = _hint(table, cells, lines)
        raise InputError(table.file, f"line {number}", f"{needed}, got {len(cells)}{hint and f': {hint}'}")
    for position, cell in enumerate(cells[table.skip :], table.skip + 1):
        if not _is_number(cell):
            reason = f"{quoted(cell.strip())} at position {position} is not a number"
            raise InputError(table.file, f"line {number}", reason)


def _hint(table: Table, cells: list[str], lines: list[Line]) -> str:
    """Return the probable cause of a wrong number of ``cells``."""
    taxels, skip, more = table.sensor.taxels, table.skip, len(cells) - table.width
    commas = len(cells) == 2 * taxels and table.separator == ","
    firsts = [float(cells[0]) for _, cells in lines if _is_number(cells[0])]  # text as 12:30:01 may be a time, too
    time = more == 1 and not skip and all(one < next_ for one, next_ in pairwise(firsts))
    other_columns = 1 < more <= _LIKE_A_TIME or (more == 1 and skip)
    hints = (
        (commas, "are these decimal commas? then numbers need another separator"),
        (skip and len(cells) == taxels, "are all columns taxels? (--skip-columns 0)"),
        (time, "is the first column a time stamp? (--skip-columns 1)"),
        (other_columns, f"are the first {skip + more} columns no taxels? (--skip-columns {skip + more})"),
    )
    return next((hint for holds, hint in hints if holds), "")


def _is_number(cell: str) -> bool:
    """Whether ``cell`` is a plain number; digits of other scripts and 1_000, which Python accepts, are not."""
    if "_" in cell or not cell.isascii():
        return False
    try:
        float(cell)
    except ValueError:
        return False
    return True


def write_table(path: Path, table: Columns) -> None:
    """Write ``table`` to ``path``, with the shortest numbers that are read back as the same double."""
    with open(path, "x", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        for start in range(0, len(next(iter(table.values()))), _ROWS):
            parts = (column[start : start + _ROWS].tolist() for column in table.values())
            writer.writerows(zip(*parts, strict=True))


FORMAT = Format((".csv", ".txt", ".tsv"), read, write_table)
