"""What a task of a study is: jobs that any process can run, and tables of their results.

The result of a job, its piece, is a string of bytes that depends only on the task and the job, not on the process or
the time.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from typing import Any, Protocol

import polars as pl

Tables = Mapping[str, pl.DataFrame]
Pieces = Callable[[int], bytes]
"""Loads the piece of the n-th job."""


class Task(Protocol):
    """A task that can be pickled; its ``repr`` identifies it."""

    @property
    def name(self) -> str:
        """One word, for the progress display and for files."""

    @property
    def unit(self) -> str:
        """Plural name of the jobs."""

    @property
    def jobs(self) -> Sequence[Any]:
        """All jobs, in order."""

    def __call__(self, job: Any) -> bytes:
        """The piece of a job."""

    def tables(self, piece: Pieces) -> Tables:
        """The tables of all pieces, by name."""


class RowTask(ABC):
    """A task whose jobs make a row each of one table with the task's name."""

    name: str
    unit = "designs"

    @property
    @abstractmethod
    def jobs(self) -> Sequence[Any]:
        """All jobs, in order."""

    @abstractmethod
    def row(self, job: Any) -> Mapping[str, Any]:
        """The row of a job, in plain values."""

    def __call__(self, job: Any) -> bytes:
        """The row as JSON."""
        return json.dumps(self.row(job)).encode()

    def tables(self, piece: Pieces) -> Tables:
        """The table."""
        rows = [json.loads(piece(number)) for number in range(len(self.jobs))]
        return {self.name: pl.DataFrame(rows, infer_schema_length=None)}


def parquet(table: pl.DataFrame) -> bytes:
    """A table as a Parquet file: the same bytes for the same table."""
    stream = BytesIO()
    table.write_parquet(stream, compression="zstd", statistics=False)
    return stream.getvalue()


def from_parquet(data: bytes) -> pl.DataFrame:
    """The table of a Parquet file."""
    return pl.read_parquet(BytesIO(data))
