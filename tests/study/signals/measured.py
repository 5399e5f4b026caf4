"""Tables of signals over blocks of converter codes, as a study makes them."""

from collections.abc import Iterable

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.signals.instrument import instrument
from tfra.study.signals.ranges import Ranges, measure_ranges
from tfra.study.signals.stages import StageErrors, measure_stages


def ranges(design: TfraDesign, blocks: Iterable[Ints]) -> pl.DataFrame:
    watched, total = instrument(design), Ranges()
    for block in blocks:
        total += measure_ranges(watched, block)
    return total.table(watched)


def broken(table: pl.DataFrame) -> pl.DataFrame:
    """The rows that exceed a word or a proven bound; there should be none."""
    return table.filter((pl.col("headroom_bits") < 0) | (pl.col("proven") & (pl.col("share") > 1)))


def stage_errors(design: TfraDesign, blocks: Iterable[Ints]) -> StageErrors:
    watched, total = instrument(design), StageErrors()
    for block in blocks:
        total += measure_stages(watched, block)
    return total


def stage_table(design: TfraDesign, blocks: Iterable[Ints]) -> pl.DataFrame:
    return stage_errors(design, blocks).errors(instrument(design))
