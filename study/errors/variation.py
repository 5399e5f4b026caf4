"""Designs that differ in one choice, compared on identical frames.

A variation changes a choice; the errors of its steps are those of a cascade on the same frames.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import polars as pl

from tfra.model.fixed.design import Design
from tfra.study.errors.cascade import SIGNED, Cascade, Step, View
from tfra.study.errors.statistics import ERRORS, errors, index_equal_rate, unflagged
from tfra.study.frames.block import Part
from tfra.study.frames.frameset import FrameSet

Facts = Mapping[str, str | int | float | None]
"""The facts of a variation, by columns of its table."""


@dataclass(frozen=True)
class Variation:
    """A ``design`` that differs from another in its ``facts``, or the ``reason`` why there is none.

    ``compared`` are the steps whose errors are wanted; ``noise`` a deviation as a share of the frame's peak instead of
    the frame's own.
    """

    facts: Facts
    design: Design | None
    reason: str | None = None
    compared: tuple[Step, ...] = (Step.ARITHMETIC,)
    noise: float | None = None

    @classmethod
    def of(cls, facts: Facts, make: Callable[[], Design], **others: Any) -> "Variation":
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
    return Cascade(frames.block(part, number), lambda: definition.noise(part, number))


COLUMNS = ERRORS | {
    "frames": pl.Int64,
    "left_out": pl.Int64,
    "sweep_index_equal": pl.Float64,
    "reason": pl.String,
}
"""Columns of :func:`rows` behind the facts, with their types."""


def rows(variation: Variation, scores: pl.DataFrame | None) -> Iterator[dict[str, Any]]:
    """Rows of a variation's table: its facts, then the columns of :func:`tfra.study.errors.statistics.errors`.

    After them are ``frames``, how many of them are ``left_out``, ``sweep_index_equal`` as the share of those swept
    alike whose index float finds, too (null where nothing is swept), and the ``reason`` why all of it is null.
    """
    if variation.design is None or scores is None:
        for quantity, step, view in product(SIGNED, variation.compared, View):
            name = {"quantity": quantity, "step": step, "view": view, "reason": variation.reason}
            yield {**variation.facts, **dict.fromkeys(COLUMNS), **name}
        return
    common = {
        "frames": len(scores),
        "left_out": int((~unflagged(scores)).sum()),
        "sweep_index_equal": index_equal_rate(scores),
        "reason": None,
    }
    for row in errors(scores, variation.compared).rows(named=True):
        yield {**variation.facts, **row, **common}
