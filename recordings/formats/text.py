"""Reading a recording from text: one frame a line, with detection of the separator."""

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.columns import Columns, by_header, by_name, by_place, guessed
from tfra.recordings.formats import Columns as Written
from tfra.recordings.formats import Format, Values, finite
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

_HEAD = 50
"""Most lines before the first frame."""

_BAD = 0.01
"""Largest share of lines that are no frames and are left out."""


@dataclass(frozen=True)
class Table:
    """How the lines of ``file`` are read: cells between separators, of which some are taxels."""

    file: Path
    sensor: SensorArray
    given: Input
    separator: str
    columns: Columns
    names: tuple[str, ...] = ()
    """Of the columns, if there is a header."""

    def split(self, line: str) -> list[str]:
        """The cells of ``line`` as they are written, without quotes around them; one if the quotes make no sense."""
        if '"' in line:
            try:
                (cells,) = csv.reader([line], delimiter=self.separator, skipinitialspace=True)
            except csv.Error:  # a cell of more than 131,072 characters, an end of the line in the middle
                return [line]
            return cells
        return line.split(None if self.separator == " " else self.separator)

    def cells(self, line: str) -> list[str]:
        """The cells of ``line``, with points in their numbers; a separator at its end has none after it."""
        cells = self.split(line)
        cells = [cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell for cell in cells]
        if len(cells) == (self.columns.width or 0) + 1 and not cells[-1].strip():
            del cells[-1]
        return cells

    def has_all(self, cells: list[str]) -> bool:
        """Whether there are as many cells as in a frame."""
        width = self.columns.width
        return len(cells) == width if width else len(cells) > max(self.columns.places)

    def taxels(self, cells: list[str]) -> list[str]:
        """The cells of the taxels, row by row or as the frame runs."""
        return [cells[place] for place in self.columns.places]

    def fits(self, line: str) -> bool:
        """Whether ``line`` has a number for every taxel, and no cells too many."""
        return self.is_frame(self.cells(line))

    def is_frame(self, cells: list[str]) -> bool:
        """The same of its ``cells``."""
        return self.has_all(cells) and all(map(_is_number, self.taxels(cells)))


def read(file: Path, sensor: SensorArray, given: Input) -> Values:
    """Return the lines of the text ``file``, ``(n, m)``, without the cells that are no taxels, of which the first is
    the time, ``(n,)``, if all of them are finite numbers, else None.  A number too large for a double is infinite.

    Separators are commas, semicolons, tabs, bars or blanks, whichever makes the first lines fit the taxels; but between
    commas a decimal comma will do.  Words before the first frame, empty lines and those that begin with # are left out,
    and a few lines that are no frames, with a note.  Raises ``InputError`` naming the line.
    """
    every = enumerate(_text(file), 1)
    texts = [(number, line) for number, line in every if line.strip() and not line.lstrip().startswith("#")]
    table, start = _begun(file, sensor, given, texts)
    lines, notes = frames_of(table, texts[start:])
    if lines and [cell.strip() for cell in table.taxels(lines[0][1])] == [str(taxel) for taxel in range(sensor.taxels)]:
        reason = f"the numbers from 0 to {sensor.taxels - 1} are headings, not stress: remove the line"
        raise InputError(file, f"line {lines[0][0]}", reason)
    values = np.empty((len(lines), sensor.taxels))
    for row, (_, cells) in zip(values, lines, strict=True):
        row[:] = [float(cell) for cell in table.taxels(cells)]
    time = table.columns.time
    times = None if time is None else _times([cells[time] for _, cells in lines])
    return Values(values, times, notes=(*notes, *_other_order(table)))


def _begun(file: Path, sensor: SensorArray, given: Input, texts: list[tuple[int, str]]) -> tuple[Table, int]:
    """The table of a file, and the number of its lines before the first frame."""
    head = [line for _, line in texts[:_HEAD]]
    if by_header(given):
        for place, line in enumerate(head, 1):
            if table := table_of_names(file, sensor, given, line):
                return table, place
        raise InputError(file, "", f"no line names {sensor.taxels} taxels as {quoted(given.columns)} (--columns)")
    tables = _tables(file, sensor, given)

    def fits(line: str) -> bool:
        return any(table.fits(line) for table in tables)

    start = 0
    while start < len(head) and _is_word(head[start]) and not fits(head[start]):
        start += 1
    if not any(map(fits, head[start : start + 2])):
        start = 0
    table = table_for(file, sensor, given, head[start : start + 2])
    if start == 0 and texts and are_headings(table.cells(texts[0][1])):
        start = 1
    return replace(table, names=tuple(table.split(head[start - 1])) if start else ()), start


def frames_of(table: Table, texts: list[tuple[int, str]]) -> tuple[list[Line], list[str]]:
    """Return the lines that are frames with their cells, and a note on those that are not if they are few.

    Raises ``InputError`` naming the first that is none if they are not few.
    """
    _require_one_point(table, texts)
    every = [(number, table.cells(line)) for number, line in texts]
    lines = [line for line in every if table.is_frame(line[1])]
    if not (bad := len(every) - len(lines)):
        return lines, []
    first = _complaint(table, next(line for line in every if not table.is_frame(line[1])), every)
    if table.given.strict or bad > _BAD * len(every):
        raise first
    reason = str(first).removeprefix(f"{table.file}: ")
    return lines, [f"{bad} of {len(every)} lines are no frames and left out (--strict refuses them): {reason}"]


def _other_order(table: Table) -> Iterator[str]:
    """Names of the header that say another order of the taxels."""
    if by_header(table.given) or len(table.names) != table.columns.width or table.given.order != "rows":
        return
    pattern = guessed(table.names, table.sensor)
    found = by_name(pattern, table.names, table.sensor) if pattern and "{row}" in pattern else None
    if found and found.places != table.columns.places:
        yield f"the header's names are in another order than row by row: are they right? (--columns {pattern})"


def table_for(file: Path, sensor: SensorArray, given: Input, first: list[str]) -> Table:
    """Return the table that the first lines of text fit; if they fit none, the one with the most helpful error."""
    tables = _tables(file, sensor, given)
    fitting = [table for table in tables if any(map(table.fits, first))]

    def numbers(table: Table) -> int:
        return sum(_is_number(cell) for line in first for cell in table.cells(line))

    return fitting[0] if fitting else max(tables, key=numbers)


def table_of_names(file: Path, sensor: SensorArray, given: Input, line: str) -> Table | None:
    """Return the table whose header ``line`` is, if its names fit ``given.columns``."""
    for separator in _SEPARATORS:
        table = Table(file, sensor, given, separator, Columns((), None))
        if columns := by_name(given.columns or "", table.split(line), sensor):
            return replace(table, columns=columns)
    return None


def _tables(file: Path, sensor: SensorArray, given: Input) -> list[Table]:
    try:
        columns = by_place(given, sensor)
    except ValueError as error:
        key, _, reason = str(error).partition(": ")
        raise InputError(file, f"input.{key}", reason) from None
    return [Table(file, sensor, given, separator, columns) for separator in _SEPARATORS]


def _is_word(line: str) -> bool:
    """Whether a line begins as a word does: with a letter, an underscore, or a quote before one."""
    return re.match(r"\s*[\"']?[^\W\d]", line) is not None


def _times(cells: list[str]) -> Floats | None:
    return finite(np.array(cells, dtype=np.float64)) if all(map(_is_number, cells)) else None


def _text(file: Path) -> list[str]:
    """Return the lines of ``file``, with any line ends."""
    with opened(file) as stream:
        data = stream.read()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(file, "", "is UTF-16 text, UTF-8 is needed")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # as spreadsheets write units; numbers are ASCII in both
        if re.search("[\x01-\x08\x0e-\x1f\x7f-\x9f]", text):
            raise InputError(file, "", "is not text in UTF-8 or Latin-1") from None
    lines = re.split("\r\n|\r|\n", text)
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
    skip = table.columns.places[0] if table.given.columns is None else 0
    first: dict[str, int] = {}
    for number, line in texts:
        for mark in re.findall("(?<=[0-9])[.,](?=[0-9])", " ".join(table.split(line)[skip:])):
            first.setdefault(mark, number)
    if len(first) == 2:
        (other, _), (here, number) = first.items()
        names = {".": "points", ",": "commas"}
        reason = f"this line has decimal {names[here]}, others have decimal {names[other]}"
        raise InputError(table.file, f"line {number}", reason)


def _complaint(table: Table, line: Line, lines: list[Line]) -> InputError:
    """What is wrong with a line that is no frame."""
    number, cells = line
    if not table.has_all(cells):
        sensor, skip = table.sensor, table.given.skip_columns
        after = f" after {skip} skipped column{'s' * (skip > 1)}" if skip else ""
        needed = f"{sensor.taxels} numbers ({sensor.rows} rows x {sensor.columns} columns){after} are needed"
        hint = _hint(table, cells, lines)
        return InputError(table.file, f"line {number}", f"{needed}, got {len(cells)}{hint and f': {hint}'}")
    place = next(place for place in table.columns.places if not _is_number(cells[place]))
    return InputError(
        table.file, f"line {number}", f"{quoted(cells[place].strip())} at position {place + 1} is not a number"
    )


def _hint(table: Table, cells: list[str], lines: list[Line]) -> str:
    """Return the probable cause of a wrong number of ``cells``."""
    taxels, skip = table.sensor.taxels, table.given.skip_columns
    more = len(cells) - (table.columns.width or len(cells))
    commas = len(cells) == 2 * taxels and table.separator == ","
    numbers = (cells[0] for _, cells in lines if cells and _is_number(cells[0]))
    firsts = list(map(float, numbers))  # text as 12:30:01 may be a time, too
    named = guessed(table.names, table.sensor)
    others = by_name(named, table.names, table.sensor) if named else None
    in_order = others is None or others.places == tuple(range(1, taxels + 1))
    time = more == 1 and not skip and in_order and all(one < next_ for one, next_ in pairwise(firsts))
    other = 1 < more <= _LIKE_A_TIME or (more == 1 and skip)
    last = f"{skip + 1}-{skip + taxels}"
    both = f"are other columns than taxels first (--skip-columns {skip + more}) or last (--columns {last})?"
    hints = (
        (commas, "are these decimal commas? then numbers need another separator"),
        (skip and len(cells) == taxels, "are all columns taxels? (--skip-columns 0)"),
        (time, "is the first column a time stamp? (--skip-columns 1)"),
        (named, f"does the header name the taxels? (--columns {named})"),
        (other, both),
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


def write_table(path: Path, table: Written) -> None:
    """Write ``table`` to ``path``, with the shortest numbers that are read back as the same double."""
    with open(path, "x", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        for start in range(0, len(next(iter(table.values()))), _ROWS):
            parts = (column[start : start + _ROWS].tolist() for column in table.values())
            writer.writerows(zip(*parts, strict=True))


FORMAT = Format((".csv", ".txt", ".tsv"), read, write_table)
