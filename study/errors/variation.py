"""Designs that differ in one choice, compared on identical frames.

A variation changes a choice; the errors of its steps are those of a cascade on the same frames.  A score does not
depend on the other variations of its job, so jobs may have any size and run anywhere.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import polars as pl

from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.cascade import SIGNED, Cascade, Step, View
from tfra.study.errors.statistics import ERRORS, errors, index_equal_rate, unflagged
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.task import Pieces, Tables, from_parquet, parquet

Facts = Mapping[str, str | int | float | None]
"""The facts of a variation, by columns of its table."""


@dataclass(frozen=True)
class Variation:
    """A ``design`` that differs from another in its ``facts``, or the ``reason`` why there is none.

    ``compared`` are the steps whose errors are wanted; ``noise`` a deviation as a share of the frame's peak instead of
    the frame's own.
    """

    facts: Facts
    design: TfraDesign | None
    reason: str | None = None
    compared: tuple[Step, ...] = (Step.ARITHMETIC,)
    noise: float | None = None

    @classmethod
    def of(cls, facts: Facts, make: Callable[[], TfraDesign], **others: Any) -> "Variation":
        """The variation whose design ``make`` gives; a ``ValueError`` of it is the reason why it does not fit."""
        try:
            design = make()
            _ = design.widths
        except ValueError as error:
            return cls(facts, None, str(error), **others)
        return cls(facts, design, **others)


def cascade_of(frames: FrameSet, part: Part, number: int) -> Cascade:
    """The cascade on a block of ``frames``."""
    definition = frames.definition
    return Cascade(definition.sensor, frames.block(part, number), lambda: definition.noise(part, number))


class Job(NamedTuple):
    """Variations from ``first`` to before ``stop`` on a block."""

    block: int
    first: int
    stop: int


@dataclass(frozen=True)
class Comparison:
    """The table ``name`` of variations on all frames of a part.

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
        cascade, scores = cascade_of(self.frames, self.part, job.block), []
        for number in range(job.first, job.stop):
            each = self.variations[number]
            if each.design:
                table = cascade(each.design, each.compared, each.noise)
                scores.append(table.with_columns(variation=pl.lit(number)))
        return parquet(pl.concat(scores, how="diagonal")) if scores else b""

    def tables(self, piece: Pieces) -> Tables:
        """The table, see :func:`rows`; the pieces of one job's variations are in memory at a time."""
        groups: dict[tuple[int, int], list[int]] = {}
        for number, job in enumerate(self.jobs):
            groups.setdefault((job.first, job.stop), []).append(number)
        table_rows: list[dict[str, Any]] = []
        for group, numbers in groups.items():
            blocks = [from_parquet(data) for data in map(piece, numbers) if data]
            scores = pl.concat(blocks) if blocks else None
            for number in range(*group):
                own = None if scores is None else scores.filter(variation=number)
                table_rows += rows(self.variations[number], own)
        return {self.name: pl.DataFrame(table_rows, schema_overrides=ERRORS | _BEHIND, infer_schema_length=None)}


_BEHIND = {"frames": pl.Int64, "left_out": pl.Int64, "sweep_index_equal": pl.Float64, "reason": pl.String}


def rows(variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
    """Rows of a variation's table: its facts, then the columns of :func:`tfra.study.errors.statistics.errors`.

    After them are ``frames``, how many of them are ``left_out``, ``sweep_index_equal`` as the share of those swept
    alike whose index float finds, too, and the ``reason`` why all of it is null.
    """
    if variation.design is None or scores is None:
        nothing = dict.fromkeys([*ERRORS, *_BEHIND])
        for quantity, step, view in product(SIGNED, variation.compared, View):
            name = {"quantity": quantity, "step": step, "view": view, "reason": variation.reason}
            yield {**variation.facts, **nothing, **name}
        return
    common = {
        "frames": len(scores),
        "left_out": int((~unflagged(scores)).sum()),
        "sweep_index_equal": index_equal_rate(scores),
        "reason": None,
    }
    for row in errors(scores, variation.compared).rows(named=True):
        yield {**variation.facts, **row, **common}
