"""The tasks that measure the design of a study: errors by step, and signals inside the core."""

import json
from dataclasses import dataclass

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.converter import convert
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.errors.statistics import errors, flagged, flips
from tfra.study.errors.variation import cascade_of
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.signals.measures import decision_table, range_table, stage_table, total
from tfra.study.signals.tfra.instrument import Instrument
from tfra.study.signals.tfra.observation import catalogue
from tfra.study.signals.tfra.signals import stage_of
from tfra.study.task import Pieces, Tables, from_parquet, parquet


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
        """Measures of a block."""
        codes: Ints = convert(self.design, self.frames.block(Part.TRAIN, job).noisy)
        return json.dumps(Instrument(self.design).measure(codes)).encode()

    def tables(self, piece: Pieces) -> Tables:
        """Tables of all blocks; that of the stages has no rows where no frame is swept."""
        measures = total(json.loads(piece(job)) for job in self.jobs)
        stages, ranges = stage_table(stage_of, measures), range_table(catalogue(self.design), measures)
        return {"stages": stages, "decisions": decision_table(measures), "ranges": ranges}
