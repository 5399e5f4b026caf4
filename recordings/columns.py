"""Which cells of a line are taxels: those after the skipped ones, a range of them, or those that the header names."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tfra.model.sensor import SensorArray
from tfra.recordings.input import Input

_RANGE = re.compile(r"(\d{1,6})-(\d{1,6})")
_NUMBERS = {"{row}": r"(?P<row>\d{1,4})", "{column}": r"(?P<column>\d{1,4})", "{taxel}": r"(?P<taxel>\d{1,6})"}

_LONGEST = 100
"""Characters of a name that may be of a taxel: the time to look at one grows with their cube."""


@dataclass(frozen=True)
class Columns:
    """``places`` of the taxels among the cells of a line, from 0; ``width``: cells of a line, None for any number."""

    places: tuple[int, ...]
    width: int | None

    @property
    def time(self) -> int | None:
        """Place of the time: the first cell, if it is no taxel."""
        return None if 0 in self.places else 0


def by_header(given: Input) -> bool:
    """Whether the taxels are found by their names."""
    return given.columns is not None and "{" in given.columns


def by_place(given: Input, sensor: SensorArray) -> Columns:
    """The columns after the skipped ones, or those of a range; raises ``ValueError`` for one of another size."""
    if given.columns is None:
        first, last = given.skip_columns, given.skip_columns + sensor.taxels
        return Columns(tuple(range(first, last)), last)
    found = _RANGE.fullmatch(given.columns)
    if not found:
        raise ValueError("columns: FIRST-LAST from 1, or names with {row} and {column}, or with {taxel}, are needed")
    places = range(int(found[1]) - 1, int(found[2]))
    if len(places) != sensor.taxels or places.start < 0:
        raise ValueError(f"columns: {sensor.taxels} columns are needed, {given.columns} are {len(places)}")
    return Columns(tuple(places), None)


def by_name(pattern: str, names: Sequence[str], sensor: SensorArray) -> Columns | None:
    """The columns whose names fit ``pattern``, row by row; None if they are not all taxels, each once.

    Numbers of rows, of columns and of taxels begin at 0 or at 1.
    """
    form = re.compile("".join(_NUMBERS.get(part, re.escape(part)) for part in re.split(r"(\{\w+\})", pattern)))
    found = {place: match for place, name in enumerate(names) if (match := form.fullmatch(name.strip().strip("\"'")))}
    if len(found) != sensor.taxels:
        return None
    numbers = [{key: int(value) for key, value in match.groupdict().items()} for match in found.values()]
    least = {key: min(each[key] for each in numbers) for key in numbers[0]}
    if not set(least.values()) <= {0, 1}:
        return None
    at = [{key: each[key] - least[key] for key in each} for each in numbers]
    taxels = [each["taxel"] if "taxel" in each else each["row"] * sensor.columns + each["column"] for each in at]
    inside = all(each.get("column", 0) < sensor.columns for each in at)
    if not inside or sorted(taxels) != list(range(sensor.taxels)):
        return None
    ordered = sorted(zip(taxels, found, strict=True))
    return Columns(tuple(place for _, place in ordered), len(names))


def guessed(names: Sequence[str], sensor: SensorArray) -> str | None:
    """A pattern that the ``names`` of a header fit, if there is one."""
    for name in (name.strip().strip("\"'") for name in names if len(name) <= _LONGEST):
        two = re.fullmatch(r"(.*?)(\d+)(\D+)(\d+)(\D*)", name)
        one = re.fullmatch(r"(.*?)(\d+)(\D*)", name)
        patterns = [f"{two[1]}{{row}}{two[3]}{{column}}{two[5]}"] if two else []
        patterns += [f"{one[1]}{{taxel}}{one[3]}"] if one else []
        for pattern in patterns:
            if by_name(pattern, names, sensor):
                return pattern
    return None
