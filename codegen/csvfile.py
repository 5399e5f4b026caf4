"""Reading frames from text: one frame a line, numbers separated by commas."""

from __future__ import annotations

import codecs
import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from tfra.codegen.inputfile import opened
from tfra.model.arrays import Floats
from tfra.model.errors import InputError, quoted
from tfra.model.sensor import SensorArray

Line = tuple[int, list[str]]
"""Its number in the file, from 1, and its cells."""

_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}


def read_csv(file: Path, sensor: SensorArray) -> Floats:
    """Return the frames of the .csv ``file``, ``(n, rows, columns)``; a number too large for a double is infinite.

    A first line of headings and empty lines are left out.  Raises ``InputError`` naming the line.
    """
    lines = [(number, line.split(",")) for number, line in enumerate(_text(file), 1) if line.strip()]
    if lines and _are_headings(lines[0][1]):
        del lines[0]
    for line in lines:
        _require_numbers(file, sensor, line, lines)
    if lines and [cell.strip() for cell in lines[0][1]] == [str(taxel) for taxel in range(sensor.taxels)]:
        reason = f"the numbers from 0 to {sensor.taxels - 1} are headings, not stress: remove the line"
        raise InputError(file, f"line {lines[0][0]}", reason)
    values = np.empty((len(lines), sensor.taxels))
    for row, (_, cells) in zip(values, lines, strict=True):
        row[:] = [float(cell) for cell in cells]
    return values.reshape(-1, sensor.rows, sensor.columns)


def _text(file: Path) -> list[str]:
    """Return the lines of ``file``, whatever they end in."""
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


def _are_headings(cells: list[str]) -> bool:
    """Headings are names: empty or starting with a letter, an underscore, a quote or #; a typo starts with none."""
    names = [cell.strip() for cell in cells]
    return not any(map(_is_number, names)) and all(
        not name or name[0].isalpha() or name[0] in "_\"'#" for name in names
    )


def _require_numbers(file: Path, sensor: SensorArray, line: Line, lines: list[Line]) -> None:
    number, cells = line
    if len(cells) != sensor.taxels:
        needed = f"{sensor.taxels} numbers ({sensor.rows} rows x {sensor.columns} columns) are needed"
        hint = _hint(sensor.taxels, cells, lines)
        raise InputError(file, f"line {number}", f"{needed}, got {len(cells)}{hint and f': {hint}'}")
    for position, cell in enumerate(cells, 1):
        if not _is_number(cell):
            raise InputError(file, f"line {number}", f"{quoted(cell.strip())} at position {position} is not a number")


def _hint(taxels: int, cells: list[str], lines: list[Line]) -> str:
    """Return what may be the matter with ``cells``, which are not as many as the taxels."""
    text = ",".join(cells).strip()
    for separator, name in _SEPARATORS.items():
        if len(text.split(separator)) == taxels:
            return f"the columns are separated by {name}; commas are needed, and points in numbers"
    if len(cells) == 2 * taxels:
        return "are there commas in numbers? points are needed"
    if len(cells) == taxels + 1 and not cells[-1].strip():
        return "the line ends in a comma"
    if len(cells) == taxels + 1 and _increases([cells[0] for _, cells in lines]):
        return "is the first column a time stamp or an index?"
    return ""


def _increases(column: list[str]) -> bool:
    numbers = [float(cell) for cell in column if _is_number(cell)]
    return all(one < next_ for one, next_ in pairwise(numbers))


def _is_number(cell: str) -> bool:
    """Tell whether ``cell`` is a plain number; Python's own digits of other scripts and 1_000 are none."""
    if "_" in cell or not cell.isascii():
        return False
    try:
        float(cell)
    except ValueError:
        return False
    return True
