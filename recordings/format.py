"""What a format of recordings is: the files of the folder ``formats`` have an object of this class each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Array
from tfra.recordings.input import Input

Columns = Mapping[str, npt.NDArray[Any]]
"""A table: one-dimensional arrays of the same length by their names."""


@dataclass(frozen=True, eq=False)
class Values:
    """What a file holds: a frame in each row or with its axes, in the unit of the file; and times, if it has them.

    The shape of ``frames`` is one that :func:`tfra.recordings.shapes.wrong_shape` accepts, without skipped columns.
    ``time (n,)`` is finite; ``seconds``: in s since the first frame, otherwise their unit is unknown.
    """

    frames: Array
    time: Floats | None = None
    seconds: bool = False


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
