"""What a format of recordings is, and all formats: each file of this folder has a ``FORMAT``.

Shapes of an array that are read as frames:

    (n, rows, columns), (rows, columns)         frames, a frame; columns come first with ``order = "columns"``
    (n, skip_columns + taxels), (taxels,)       a frame in each row, a frame

No shape is ambiguous: a sensor has at least two rows and two columns, so neither number equals that of the taxels.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Array, Shape
from tfra.recordings.input import Input
from tfra.runtime.errors import shortened

FRAMES = "frames"
"""The key of the stresses."""

Columns = Mapping[str, npt.NDArray[Any]]
"""A table: one-dimensional arrays of the same length by their names."""


@dataclass(frozen=True, eq=False)
class Values:
    """What a file holds: a frame in each row or with its axes, in the unit of the file; and times, if it has them.

    The shape of ``frames`` is one that ``wrong_shape`` accepts, without skipped columns.
    ``time (n,)`` is finite; ``seconds``: in s since the first frame, otherwise their unit is unknown.  ``notes`` are
    warnings.
    """

    frames: Array
    time: Floats | None = None
    seconds: bool = False
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Format:
    """A format of recordings, and perhaps of results.

    ``suffixes`` are those of its files, in small letters; ``marker`` is a file in a folder that is of this format.
    ``read`` returns the content of a file, and raises ``InputError`` that names it.  ``write_table`` writes a table to
    a file that does not exist; None: no results are written.  ``needs``: the extra that the format needs, and its
    packages.
    """

    suffixes: tuple[str, ...]
    read: Callable[[Path, SensorArray, Input], Values]
    write_table: Callable[[Path, Columns], None] | None = None
    marker: str = ""
    needs: tuple[str, ...] = ()

    def accepts(self, path: Path) -> bool:
        """Whether the file or folder at ``path`` is of this format, by its name."""
        return path.suffix.lower() in self.suffixes or bool(self.marker and (path / self.marker).is_file())


def finite(times: Array) -> Floats | None:
    """Return ``times (n,)`` in double precision; None if one is not finite."""
    numbers = times.astype(np.float64)
    return numbers if np.isfinite(numbers).all() else None


def split(array: Array, sensor: SensorArray, given: Input) -> tuple[Array, Floats | None]:
    """Return the frames of ``array``, ``(n, taxels)`` or ``(n, ...)``, and the times before them, if any.

    Its shape must be one that ``wrong_shape`` accepts.
    """
    if array.shape in (given.shape(sensor), (sensor.taxels,)):
        return array[None], None
    if array.ndim == 3 or not given.skip_columns:
        return array, None
    return array[:, given.skip_columns :], finite(array[:, 0])


def wrong_shape(sensor: SensorArray, given: Input, shape: Shape) -> str | None:
    """Return what is wrong with a ``shape`` that is not one of frames, and what it may be."""
    frame, width, skip = given.shape(sensor), sensor.taxels + given.skip_columns, given.skip_columns
    if shape in (frame, (sensor.taxels,)):
        return None
    if (len(shape) == 3 and shape[1:] == frame) or (len(shape) == 2 and shape[1] == width):
        return None
    other = "columns" if given.order == "rows" else "rows"
    axes, cells = len(shape), shape[1] if len(shape) == 2 else 0
    hints = (
        (shape[-2:] == frame[::-1] and axes in (2, 3), f": is every frame transposed? (--order {other})"),
        (axes == 3 and shape[:2] == frame, ": are frames along the last axis? they must be along the first"),
        (skip and cells == sensor.taxels, ": are all columns taxels? (--skip-columns 0)"),
        (cells == sensor.taxels + 1, ": is the first column a time stamp? (--skip-columns 1)"),
    )
    hint = next((hint for holds, hint in hints if holds), "")
    return f"shape (n, {frame[0]}, {frame[1]}) or (n, {width}) is needed, got {shortened(str(shape))}{hint}"


@cache
def formats() -> tuple[Format, ...]:
    """Return the formats of this folder's files."""
    return tuple(import_module(f"{__name__}.{module.name}").FORMAT for module in iter_modules(__path__))


def format_of(path: Path) -> Format | None:
    """Return the format of the file or folder at ``path``; None if no format accepts its name."""
    return next((each for each in formats() if each.accepts(path)), None)


def suffixes() -> list[str]:
    """Return the suffixes of all formats."""
    return sorted(suffix for each in formats() for suffix in each.suffixes)


def table_formats() -> dict[str, Format]:
    """Return the formats that results can be written in, by the first of their suffixes."""
    found = {each.suffixes[0]: each for each in formats() if each.write_table}
    return {suffix: found[suffix] for suffix in sorted(found)}
