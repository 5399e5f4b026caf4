"""The tasks of a study: jobs that any process can run, and tables of their results.

The result of a job, its piece, is a string of bytes that depends only on the task and the job, not on the process or
the time.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.converter import convert
from tfra.model.fixed.design import Design
from tfra.study.errors.statistics import errors, flagged, flips, unflagged
from tfra.study.errors.variation import COLUMNS, Variation, cascade_of, rows
from tfra.study.frames.block import Part, from_parquet, parquet
from tfra.study.frames.frameset import FrameSet
from tfra.study.report.labels import Tables
from tfra.study.signals.instruments import instrument
from tfra.study.signals.measures import decision_table, length_table, range_table, stage_table, total

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


@dataclass(frozen=True)
class Errors:
    """Errors and decisions of ``design`` by step, on all frames."""

    design: Design
    frames: FrameSet
    name = "errors"
    unit = "blocks"
    makes = ("errors", "flagged", "flips")

    @property
    def jobs(self) -> list[tuple[Part, int]]:
        """The blocks of both parts."""
        return self.frames.definition.all_blocks()

    def __call__(self, job: tuple[Part, int]) -> bytes:
        """Scores of a block."""
        return parquet(cascade_of(self.frames, *job)(self.design))

    def tables(self, piece: Pieces) -> Tables:
        """Tables of both parts, the part in their first column."""
        tables: dict[str, list[pl.DataFrame]] = {name: [] for name in self.makes}
        for part in Part:
            blocks = [from_parquet(piece(number)) for number, (of, _) in enumerate(self.jobs) if of is part]
            for name, table in zip(self.makes, (errors, flagged, flips) if blocks else (), strict=False):
                tables[name].append(table(pl.concat(blocks)).insert_column(0, pl.lit(str(part)).alias("part")))
        return {name: pl.concat(parts) for name, parts in tables.items()}


@dataclass(frozen=True)
class Signals:
    """SQNR of all stages of ``design``, ranges and lengths of all signals, on the training frames."""

    design: Design
    frames: FrameSet
    name = "signals"
    unit = "blocks"
    makes = ("stages", "decisions", "ranges", "lengths")

    @property
    def jobs(self) -> range:
        """The blocks of the training part."""
        return range(self.frames.definition.blocks(Part.TRAIN))

    def __call__(self, job: int) -> bytes:
        """Measures of a block."""
        codes: Ints = convert(self.design, self.frames.block(Part.TRAIN, job).noisy)
        return json.dumps(instrument(self.design).measure(codes)).encode()

    def tables(self, piece: Pieces) -> Tables:
        """Tables of all blocks; that of the stages has no rows where no frame is swept."""
        measures, inside = total(json.loads(piece(job)) for job in self.jobs), instrument(self.design)
        return {
            "stages": stage_table(inside.stage_of, measures),
            "decisions": decision_table(measures),
            "ranges": range_table(inside.catalogue, measures),
            "lengths": length_table(self.design, measures),
        }


@dataclass(frozen=True)
class Estimators:
    """Errors of several ``designs``, by their names, on the same frames: those that no step of any of them flags."""

    designs: tuple[tuple[str, Design], ...]
    frames: FrameSet
    name = "estimators"
    unit = "blocks"
    makes = ("estimators",)

    @property
    def jobs(self) -> list[tuple[Part, int]]:
        """The blocks held out, those of the training where there are none."""
        blocks = self.frames.definition.all_blocks()
        return [block for block in blocks if block[0] is Part.HELD_OUT] or blocks

    def __call__(self, job: tuple[Part, int]) -> bytes:
        """Scores of a block."""
        cascade = cascade_of(self.frames, *job)
        scores = [cascade(design).with_columns(design=pl.lit(name)) for name, design in self.designs]
        return parquet(pl.concat(scores, how="diagonal"))

    def tables(self, piece: Pieces) -> Tables:
        """Rows as :func:`tfra.study.errors.statistics.errors`, behind the ``design`` and its ``estimator``."""
        scores = pl.concat([from_parquet(piece(number)) for number in range(len(self.jobs))])
        keep = scores["frame"].filter(unflagged(scores)).value_counts().filter(count=len(self.designs))["frame"]
        table_rows = [
            {"design": name, "estimator": design.estimator, **row}
            for name, design in self.designs
            for row in errors(scores.filter(pl.col("frame").is_in(keep.implode()), design=name)).rows(named=True)
        ]
        return {self.name: pl.DataFrame(table_rows, infer_schema_length=None)}


Scoring = Callable[..., pl.DataFrame]
"""A cascade on a block: of a design, the steps compared and the noise, as a variation has them."""


class Job(NamedTuple):
    """Variations from ``first`` to before ``stop`` on a block."""

    block: int
    first: int
    stop: int


@dataclass(frozen=True)
class Comparison:
    """The table ``name`` of variations on all frames of a part, whose scores do not depend on the split into jobs.

    BLAS must have the same number of threads in all processes; then tables are the same for any number of processes.
    """

    name: str
    frames: FrameSet
    variations: tuple[Variation, ...]
    part: Part = Part.TRAIN
    together: int = 16
    unit = "jobs"

    @property
    def jobs(self) -> list[Job]:
        """Block by block, of up to ``together`` variations: the float estimates are made once for a job."""
        count = len(self.variations)
        return [
            Job(block, first, min(first + self.together, count))
            for block in range(self.frames.definition.blocks(self.part))
            for first in range(0, count, self.together)
        ]

    def __call__(self, job: Job) -> bytes:
        """Scores of a job's variations, some 100 bytes a frame for one step; empty if none of them fits."""
        cascade, scores = self._cascade(job.block), []
        for number in range(job.first, job.stop):
            each = self.variations[number]
            if each.design:
                table = cascade(each.design, each.compared, each.noise)
                scores.append(table.with_columns(variation=pl.lit(number)))
        return parquet(pl.concat(scores, how="diagonal")) if scores else b""

    def tables(self, piece: Pieces) -> Tables:
        """The table of :func:`tfra.study.errors.variation.rows`; one job's variations are in memory at a time."""
        groups: dict[tuple[int, int], list[int]] = {}
        for number, job in enumerate(self.jobs):
            groups.setdefault((job.first, job.stop), []).append(number)
        table_rows: list[dict[str, Any]] = []
        for group, numbers in groups.items():
            blocks = [from_parquet(data) for data in map(piece, numbers) if data]
            scores = pl.concat(blocks) if blocks else None
            for number in range(*group):
                own = None if scores is None else scores.filter(variation=number)
                table_rows += self._rows(self.variations[number], own)
        return {self.name: pl.DataFrame(table_rows, schema_overrides=self._columns, infer_schema_length=None)}

    def _cascade(self, block: int) -> Scoring:
        return cascade_of(self.frames, self.part, block)

    def _rows(self, variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
        return rows(variation, scores)

    @property
    def _columns(self) -> Mapping[str, type[pl.DataType]]:
        return COLUMNS
