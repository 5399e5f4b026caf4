"""The tasks of a skin's study, as :mod:`tfra.study.tasks` has those of a single array."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import polars as pl

from tfra.model.skin.skin import Skin
from tfra.study.errors.variation import Variation
from tfra.study.frames.block import Part, from_parquet, parquet
from tfra.study.frames.frameset import FrameSet
from tfra.study.report.labels import Tables
from tfra.study.skins.cascade import SkinCascade
from tfra.study.skins.comparisons import COLUMNS, rows
from tfra.study.skins.statistics import by_group, errors, finding, marked
from tfra.study.tasks import Comparison, Pieces, Scoring

_MADE = {"errors": errors, "finding": finding, "groups": by_group, "marked": marked}


def cascade_of(skin: Skin, frames: FrameSet, part: Part, number: int) -> SkinCascade:
    """The cascade on a block of ``frames``."""
    return SkinCascade(skin, frames.block(part, number), lambda: frames.definition.noise(part, number))


@dataclass(frozen=True)
class Contacts:
    """What is found of all contacts of ``skin``, by step, and the errors of it."""

    skin: Skin
    frames: FrameSet
    name = "contacts"
    unit = "blocks"
    makes = tuple(_MADE)

    @property
    def jobs(self) -> list[tuple[Part, int]]:
        """The blocks of both parts."""
        return self.frames.definition.all_blocks()

    def __call__(self, job: tuple[Part, int]) -> bytes:
        """Scores of a block."""
        return parquet(cascade_of(self.skin, self.frames, *job)(self.skin.window))

    def tables(self, piece: Pieces) -> Tables:
        """Tables of both parts, the part in their first column."""
        tables: dict[str, list[pl.DataFrame]] = {name: [] for name in _MADE}
        for part in Part:
            blocks = [from_parquet(piece(number)) for number, (of, _) in enumerate(self.jobs) if of is part]
            for name, table in _MADE.items() if blocks else ():
                tables[name].append(table(pl.concat(blocks)).insert_column(0, pl.lit(str(part)).alias("part")))
        return {name: pl.concat(parts) for name, parts in tables.items()}


@dataclass(frozen=True)
class SkinComparison(Comparison):
    """The table ``name`` of variations of the windows of ``skin``."""

    skin: Skin = field(kw_only=True)

    def _cascade(self, block: int) -> Scoring:
        return cascade_of(self.skin, self.frames, self.part, block)

    def _rows(self, variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
        return rows(variation, scores)

    @property
    def _columns(self) -> Mapping[str, Any]:
        return COLUMNS
