"""Evaluation of a design: its errors on frames relative to float arithmetic, and the costs of its core.

Errors are measured first, since they take least time, and on few frames before all: a design with a hopeless error
there is dropped.  Resources that need an elaborated core come last, and only on request.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tfra.families import Target
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import convert
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.tfra import Result, Status
from tfra.sim.compiled import quickest
from tfra.study.errors.cascade import differences
from tfra.study.errors.statistics import BEYOND
from tfra.study.frames.block import Block, Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.search.costs import costs_of
from tfra.study.search.search import Measured
from tfra.study.search.space import Point, Space
from tfra.study.search.trials import COMPLETE, STOPPED, UNFIT

CHANGE = "total_change_percent"
"""Excess of the 95th percentile of the total error over that of float arithmetic, in the worst quantity."""

QUANTITIES = (
    "phi_deg",
    "mu",
    "force_difference_percent_of_true_force",
    "taxel_forces_percent_of_true_taxel_forces",
)
"""Quantities whose errors count, unless others are named."""

_LOOKS = ((1, 15.0), (4, 5.0))
"""Blocks that are measured before all others, and the allowed excess over the limit there, in percent."""

LEAST = 20 * BEYOND
"""Least frames for a 95th percentile; with fewer it would depend on single frames."""

BLOCKS_IN_MEMORY = 64
"""Samples that a process keeps for its next design: 65,536 frames, some 200 MB at 10x10."""


@dataclass(frozen=True)
class Sample:
    """A block's codes, its truth, and which frames count: those that the float estimator flags at no step.

    It is the same for all designs that differ only in formats and lanes.  ``exact`` are magnitudes of the
    total errors of float arithmetic on the codes, by quantity, of the frames that count.
    """

    codes: Ints
    block: Block
    counted: Bools
    exact: Mapping[str, Floats]

    @classmethod
    def of(cls, design: Design, block: Block) -> "Sample":
        """The sample of ``block`` for the converter and the search of ``design``."""
        codes, in_float = convert(design, block.noisy), design.float_model
        result = in_float(codes * design.adc.lsb)
        status = in_float(block.stress).status | in_float(block.noisy).status | result.status
        counted = status & ~int(Status.INPUT_SATURATED) == 0
        return cls(codes, block, counted, _magnitudes(block, result, counted))

    def errors(self, design: Design, words: Callable[[Ints], Ints]) -> dict[str, Floats]:
        """The same as ``exact``, of ``design``, whose model is ``words``."""
        return _magnitudes(self.block, decode(design, words(self.codes)), self.counted)


def _magnitudes(block: Block, result: Result, counted: Bools) -> dict[str, Floats]:
    return {name: np.abs(values[counted]) for name, values in differences(block, block, result).items()}


@dataclass(frozen=True)
class Evaluation:
    """Measures points of a space around ``base``, on the frames of a part, for cores on ``target``.

    ``costs`` are of ``COSTS``, ``quantities`` those whose errors count; a design is dropped if ``CHANGE`` exceeds
    ``limit`` percent.
    """

    base: Design
    frames: FrameSet
    costs: tuple[str, ...]
    target: Target
    quantities: tuple[str, ...] = QUANTITIES
    limit: float = math.inf
    part: Part = Part.TRAIN

    def __call__(self, point: Point) -> Measured:
        """``CHANGE``, the 95th percentile of each error that counts, and costs, as long as the limit is met."""
        try:
            design = Space.design(self.base, point)
        except ValueError as error:
            return Measured(UNFIT, {}, str(error))
        blocks = self.blocks
        for count, slack in (*((few, slack) for few, slack in _LOOKS if few < blocks), (blocks, 0.0)):
            try:
                values = self.errors(design, count)
            except TooFewError:
                if count == blocks:
                    raise
                continue
            if values[CHANGE] > self.limit + slack:
                excess = f"{values[CHANGE]:.4g} on {count} of {blocks} blocks is over {self.limit + slack:g}"
                return Measured(STOPPED, values, f"{CHANGE}: {excess}")
        return Measured(COMPLETE, values | self.cost_values(design))

    @property
    def blocks(self) -> int:
        """Number of blocks of the part."""
        return self.frames.definition.blocks(self.part)

    def errors(self, design: Design, count: int) -> dict[str, float]:
        """``CHANGE``, and the 95th percentile of each error that counts, on the first blocks of the part."""
        samples = [self._sample(design, number) for number in range(count)]
        exact = self._percentiles([sample.exact for sample in samples])
        words = quickest(design)
        errors = self._percentiles([sample.errors(design, words) for sample in samples])
        return {CHANGE: max(map(_change, exact.values(), errors.values())), **errors}

    def exact(self) -> dict[str, float]:
        """The 95th percentile of each error of float arithmetic on the codes, on all blocks."""
        return self._percentiles([self._sample(self.base, number).exact for number in range(self.blocks)])

    def _percentiles(self, blocks: Sequence[Mapping[str, Floats]]) -> dict[str, float]:
        return {name: percentile(np.concatenate([errors[name] for errors in blocks])) for name in self.quantities}

    def _sample(self, design: Design, number: int) -> Sample:
        return _sample(replace(self.base, search=design.search), self.frames, self.part, number)

    def cost_values(self, design: Design) -> dict[str, float]:
        """The ``costs`` of a design."""
        return costs_of(design, self.costs, self.target.family)


def _change(exact: float, error: float) -> float:
    """In percent; where float arithmetic has no error, any is too much."""
    if not exact:
        return math.inf if error else 0.0
    return 100 * (error / exact - 1)


class TooFewError(ValueError):
    """Frames that count are too few for a percentile."""


def percentile(errors: Floats) -> float:
    """The 95th percentile of ``errors``, those left out that are unknown or undefined.

    Raises :class:`TooFewError` where there are fewer than ``LEAST``.
    """
    known = errors[~np.isnan(errors)]
    if len(known) < LEAST:
        raise TooFewError(f"frames: {len(known)} frames that count are too few for a 95th percentile")
    return float(np.quantile(known, 0.95))


@lru_cache(maxsize=BLOCKS_IN_MEMORY)
def _sample(base: Design, frames: FrameSet, part: Part, number: int) -> Sample:
    """Made once in each process that measures, since the float steps take longer than a design's own."""
    return Sample.of(base, frames.block(part, number))
