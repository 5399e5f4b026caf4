"""Reading a recording from a table in Parquet: a column for each taxel, or one column of lists."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tfra.model.arrays import Floats
from tfra.model.sensor import SensorArray
from tfra.recordings.arrays import Array
from tfra.recordings.formats import FRAMES, Columns, Format, Values, finite, wrong_shape
from tfra.recordings.input import Input
from tfra.runtime.errors import InputError, quoted
from tfra.runtime.inputs import opened
from tfra.runtime.processes import running
from tfra.runtime.scratch import scratch, temporary

if TYPE_CHECKING:
    import polars as pl

_MAGIC = b"PAR1"

_CONVERTED = "import sys, polars; polars.read_parquet(sys.argv[1], glob=False).write_ipc(sys.argv[2])"
"""Polars runs in a separate process, because a damaged file can crash it."""


def read(file: Path, sensor: SensorArray, given: Input) -> Values:
    """Return the rows of ``file`` after the columns that are skipped; the first of these is the time if it is of finite
    numbers.

    Raises ``InputError`` for a file that is damaged, columns that are no real numbers, and empty cells.
    """
    table = _table(file)
    names = table.columns[given.skip_columns :]
    if not names:
        raise InputError(file, FRAMES, f"{given.skip_columns} of {table.width} columns are skipped (--skip-columns)")
    values = _list(file, table[names[0]]) if len(names) == 1 else _columns(file, table.select(names))
    frame = values.shape[1:] if values.ndim > 2 else (given.skip_columns + values.shape[1],)
    if reason := wrong_shape(sensor, given, (1, *frame)):
        raise InputError(file, FRAMES, reason)
    return Values(values, _time(table.to_series(0)) if given.skip_columns else None)


def _table(file: Path) -> pl.DataFrame:
    import polars as pl

    with opened(file) as stream:
        start, length = stream.read(len(_MAGIC)), stream.seek(0, os.SEEK_END)
        stream.seek(max(0, length - len(_MAGIC)))
        if start != _MAGIC or stream.read() != _MAGIC:
            raise InputError(file, "", "is not a Parquet file, or ends early")
    with scratch(temporary()) as folder:
        command = [sys.executable, "-c", _CONVERTED, str(file.absolute()), "table.arrow"]
        with running(command, folder, stdout=subprocess.DEVNULL) as process:
            code = process.wait()
        if code:
            raise InputError(file, "", "is not a readable Parquet file: is it damaged?")
        return pl.read_ipc((folder / "table.arrow").read_bytes())


def _columns(file: Path, table: pl.DataFrame) -> Array:
    for name, kind in table.schema.items():
        if not kind.is_numeric():
            raise InputError(file, f"column {quoted(name)}", f"real numbers are needed, got {kind}")
        _require_full(file, table[name])
    return table.to_numpy()


def _list(file: Path, column: pl.Series) -> Array:
    """The lists or arrays of ``column``, which are all as long."""
    import polars as pl

    name, inner = f"column {quoted(column.name)}", column.dtype
    while isinstance(inner, pl.List | pl.Array):
        inner = inner.inner  # type: ignore[assignment]  # a class stands for its instance there
    if not isinstance(column.dtype, pl.List | pl.Array) or not inner.is_numeric():
        raise InputError(file, name, f"lists of real numbers are needed, got {column.dtype}")
    axes = [len(column)]
    while isinstance(column.dtype, pl.List | pl.Array):
        _require_full(file, column)
        lengths = column.list.len() if isinstance(column.dtype, pl.List) else pl.Series([column.dtype.shape[0]])
        if lengths.n_unique() > 1 or 0 in lengths:
            raise InputError(file, name, "all lists must have the same length, more than 0")
        axes.append(int(lengths[0]) if len(lengths) else 0)
        column = column.explode(empty_as_null=False) if len(column) else column.explode()
    _require_full(file, column)
    return column.to_numpy().reshape(axes)


def _require_full(file: Path, column: pl.Series) -> None:
    if column.null_count():
        frame = column.is_null().arg_max()
        raise InputError(file, f"column {quoted(column.name)}", f"lacks a value, first at {frame}")


def _time(column: pl.Series) -> Floats | None:
    if not column.dtype.is_numeric() or column.null_count():
        return None
    return finite(column.to_numpy())


def write_table(path: Path, table: Columns) -> None:
    """Write ``table`` to ``path``; equal tables give equal bytes."""
    import polars as pl

    pl.DataFrame(dict(table)).write_parquet(path, compression="zstd", statistics=False)


FORMAT = Format((".parquet",), read, write_table, needs=("tables", "polars"))
