"""Measures of signals over blocks of converter codes, as a study makes them."""

from collections.abc import Iterable

import polars as pl

from tfra.model.arrays import Ints
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.study.signals.measures import Measures, range_table, stage_table, total
from tfra.study.signals.tfra.instrument import Instrument
from tfra.study.signals.tfra.observation import catalogue
from tfra.study.signals.tfra.signals import stage_of


def ranges(design: TfraDesign, blocks: Iterable[Ints]) -> pl.DataFrame:
    traces = (trace for block in blocks for trace in FixedTfra(design).traces(block))
    return range_table(catalogue(design), total(map(Instrument(design).ranges, traces)))


def measures(design: TfraDesign, blocks: Iterable[Ints]) -> Measures:
    return total(map(Instrument(design).measure, blocks))


def stages(design: TfraDesign, codes: Ints) -> pl.DataFrame:
    return stage_table(stage_of, measures(design, [codes]))
