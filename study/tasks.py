"""The tasks of a study: each has jobs that any process can run, and makes tables of their results.

A piece is a string of bytes that depends only on the task and the job, not on the process or the time.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from typing import Any, Protocol

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.converter import convert
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.cascade import Cascade
from tfra.study.errors.statistics import errors, flagged, flips
from tfra.study.errors.variation import Comparison, Job
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.signals.instrument import instrument
from tfra.study.signals.ranges import Ranges, measure_ranges
from tfra.study.signals.stages import StageErrors, measure_stages

Tables = Mapping[str, pl.DataFrame]

TOGETHER = 16
"""Variations of a job: what they have in common is computed once."""


class Task(Protocol):
    """``unit`` is the name of a job in the progress display."""

    @property
    def name(self) -> str:
        """Of the task, in one word."""

    @property
    def unit(self) -> str:
        """Plural name of the jobs."""

    @property
    def makes(self) -> tuple[str, ...]:
        """Names of the tables."""

    @property
    def jobs(self) -> Sequence[Any]:
        """All jobs, in order."""

    def __call__(self, job: Any) -> bytes:
        """Do a job."""

    def tables(self, piece: Callable[[int], bytes]) -> Tables:
        """Make the tables of all pieces; ``piece`` loads that of the n-th job."""


@dataclass(frozen=True)
class Errors:
    """Errors and decisions of ``design`` by step, on all frames."""

    design: TfraDesign
    frames: FrameSet
    name = "errors"
    unit = "blocks"
    makes = ("errors", "flagged", "flips")

    @property
    def jobs(self) -> list[tuple[Part, int]]:
        """The blocks of both parts."""
        return [(part, number) for part in Part for number in range(self.frames.definition.blocks(part))]

    def __call__(self, job: tuple[Part, int]) -> bytes:
        """Scores of a block."""
        return parquet(Cascade(self.design)(self.frames.block(*job)))

    def tables(self, piece: Callable[[int], bytes]) -> Tables:
        """Tables of both parts, the part in their first column."""
        made: dict[str, list[pl.DataFrame]] = {name: [] for name in self.makes}
        for part in Part:
            blocks = [from_parquet(piece(n)) for n, (of, _) in enumerate(self.jobs) if of is part]
            scores = pl.concat(blocks) if blocks else None
            for name, table in zip(self.makes, (errors, flagged, flips), strict=True):
                if scores is not None:
                    made[name].append(table(scores).insert_column(0, pl.lit(str(part)).alias("part")))
        return {name: pl.concat(tables) for name, tables in made.items()}


@dataclass(frozen=True)
class Signals:
    """SQNR of all stages of ``design``, and ranges of all signals, on the training frames."""

    design: TfraDesign
    frames: FrameSet
    name = "signals"
    unit = "blocks"
    makes = ("stages", "decisions", "ranges")

    @property
    def jobs(self) -> range:
        """The blocks of the training part."""
        return range(self.frames.definition.blocks(Part.TRAIN))

    def __call__(self, job: int) -> bytes:
        """Sums and extremes of a block."""
        codes: Ints = convert(self.design, self.frames.block(Part.TRAIN, job).noisy)
        watched = instrument(self.design)
        measured = measure_stages(watched, codes), measure_ranges(watched, codes)
        return json.dumps([each.document() for each in measured]).encode()

    def tables(self, piece: Callable[[int], bytes]) -> Tables:
        """Tables of all blocks; that of the stages has no rows where no frame is swept."""
        stages, ranges = StageErrors(), Ranges()
        for job in self.jobs:
            of_stages, of_ranges = json.loads(piece(job))
            stages += StageErrors.of(of_stages)
            ranges += Ranges.of(of_ranges)
        watched = instrument(self.design)
        return {
            "stages": stages.errors(watched),
            "decisions": stages.decisions(),
            "ranges": ranges.table(watched),
        }


@dataclass(frozen=True)
class Compared:
    """The table ``name`` of a comparison."""

    name: str
    comparison: Comparison
    unit = "jobs"

    @property
    def makes(self) -> tuple[str, ...]:
        """The one table."""
        return (self.name,)

    @property
    def jobs(self) -> list[Job]:
        """Up to ``TOGETHER`` variations on a block each."""
        return self.comparison.jobs(TOGETHER)

    def __call__(self, job: Job) -> bytes:
        """Scores of some variations on a block, concatenated, without those that do not fit."""
        scores = self.comparison(job)
        there = [table.with_columns(variation=pl.lit(n)) for n, table in enumerate(scores) if table is not None]
        return parquet(pl.concat(there, how="diagonal")) if there else b""

    def tables(self, piece: Callable[[int], bytes]) -> Tables:
        """The table of all variations; the pieces of a few of them are in memory at a time."""
        groups: dict[tuple[int, int], list[int]] = {}
        for number, job in enumerate(self.jobs):
            groups.setdefault((job.first, job.stop), []).append(number)
        return {self.name: pl.concat([self._rows(*group, numbers, piece) for group, numbers in groups.items()])}

    def _rows(self, first: int, stop: int, numbers: Sequence[int], piece: Callable[[int], bytes]) -> pl.DataFrame:
        some = replace(self.comparison, variations=self.comparison.variations[first:stop])
        jobs = [Job(self.jobs[number].block, 0, stop - first) for number in numbers]
        return some.table(jobs, [_apart(piece(number), stop - first) for number in numbers])


def _apart(data: bytes, count: int) -> list[pl.DataFrame | None]:
    if not data:
        return [None] * count
    scores = from_parquet(data)
    there = {n: scores.filter(pl.col("variation") == n).drop("variation") for n in scores["variation"].unique()}
    return [there.get(n) for n in range(count)]


def parquet(table: pl.DataFrame) -> bytes:
    """A table as a Parquet file: the same bytes for the same table."""
    stream = BytesIO()
    table.write_parquet(stream, compression="zstd", statistics=False)
    return stream.getvalue()


def from_parquet(data: bytes) -> pl.DataFrame:
    """The table of a Parquet file."""
    return pl.read_parquet(BytesIO(data))
