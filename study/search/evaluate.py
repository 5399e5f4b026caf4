"""What a design of a search is worth: its errors on frames, and what its core takes.

Errors come first, since they cost least, and the first block alone before all: a design that is beyond a limit there is
given up.  The core is elaborated last, and only if an objective asks for its resources.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.converter import convert
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.words import decode
from tfra.model.tfra import Status, Tfra
from tfra.study.errors.cascade import SIGNED, differences
from tfra.study.errors.statistics import BEYOND
from tfra.study.frames.block import Block, Part
from tfra.study.frames.frameset import FrameSet
from tfra.study.search.search import Measured
from tfra.study.search.space import Point, Space
from tfra.study.search.trials import COMPLETE, STOPPED, UNFIT
from tfra.synth.estimate import estimate
from tfra.synth.targets import Target

CYCLES = ("latency_cycles", "interval_cycles")
RESOURCES = ("LUT", "FF", "DSP", "BRAM")
COSTS = ("coefficient_kbit", *CYCLES, *RESOURCES)
"""What a core takes: bits of all coefficients, each counted once; by its timeline; by the estimate."""

OBJECTIVES = (*SIGNED, *COSTS)
"""What a search may make small: the 95th percentile of the total error in a quantity, and costs."""

BLOCKS_IN_MEMORY = 64
"""Samples that a process keeps for its next design: 65,536 frames, some 200 MB at 10x10."""


@dataclass(frozen=True)
class Sample:
    """A block's codes, its truth, and which frames count: those that float TFRA flags at no step.

    It is one and the same for all designs that differ in formats and lanes alone.
    """

    codes: Ints
    block: Block
    kept: Bools

    @classmethod
    def of(cls, design: TfraDesign, block: Block) -> Sample:
        """The sample of ``block`` for the converter and the search of ``design``."""
        codes, tfra = convert(design, block.noisy), Tfra.of(design)
        status = tfra(block.stress).status | tfra(block.noisy).status | tfra(codes * design.adc.lsb).status
        return cls(codes, block, status & ~int(Status.INPUT_SATURATED) == 0)

    def errors(self, design: TfraDesign) -> dict[str, Floats]:
        """Magnitudes of the total errors of ``design`` by quantity, of the frames that count."""
        found = decode(design, design.model(self.codes).words)
        errors = differences(self.block, self.block, found)
        return {name: np.abs(values[self.kept]) for name, values in errors.items()}


@dataclass(frozen=True)
class Evaluation:
    """Measures points of ``space`` around ``base``, on the frames of a part, for cores on ``target``.

    ``objectives`` are of ``OBJECTIVES``; a design with a value over that of ``limits`` is given up.
    """

    base: TfraDesign
    space: Space
    frames: FrameSet
    objectives: tuple[str, ...]
    target: Target
    limits: Mapping[str, float] = field(default_factory=dict)
    part: Part = Part.TRAIN

    def __call__(self, point: Point) -> Measured:
        """Errors and costs of a point, in that order, as long as they are within the limits."""
        try:
            design = self.space.design(self.base, point)
        except ValueError as error:
            return Measured(UNFIT, {}, str(error))
        blocks = range(self.frames.definition.blocks(self.part))
        values: dict[str, float] = {}
        for look in (blocks[:1], blocks):
            values = self.errors(design, look)
            if reason := self._beyond(values):
                return Measured(STOPPED, values, reason)
        values |= self.costs(design)
        reason = self._beyond(values)
        return Measured(STOPPED if reason else COMPLETE, values, reason)

    def errors(self, design: TfraDesign, blocks: Iterable[int]) -> dict[str, float]:
        """The objectives that are errors, on some blocks of the part."""
        wanted = [name for name in self.objectives if name in SIGNED]
        found = [self._sample(design, number).errors(design) for number in blocks] if wanted else []
        return {name: percentile(np.concatenate([errors[name] for errors in found])) for name in wanted}

    def _sample(self, design: TfraDesign, number: int) -> Sample:
        alike = replace(self.base, search=design.search)
        return _sample(_Place(self.frames.folder, self.frames.definition.hash, self.part, number, alike, self.frames))

    def costs(self, design: TfraDesign) -> dict[str, float]:
        """The objectives that are costs."""
        wanted = [name for name in self.objectives if name in COSTS]
        core = microarchitecture(design)
        found = {"coefficient_kbit": design.coefficient_bits / 1000}
        if any(name in CYCLES for name in wanted):
            found |= {"latency_cycles": float(core.latency), "interval_cycles": float(core.initiation_interval)}
        if any(name in RESOURCES for name in wanted):
            found |= {name: float(used) for name, used in estimate(design, self.target.family).total.items()}
        return {name: found[name] for name in wanted}

    def _beyond(self, values: Mapping[str, float]) -> str:
        """Why a design is given up, or nothing."""
        for name, most in self.limits.items():
            if values.get(name, most) > most:
                return f"{name}: {values[name]:.4g} is over the limit of {most:.4g}"
        return ""


def percentile(errors: Floats) -> float:
    """The 95th percentile of ``errors``, those left out that are unknown or undefined.

    Raises ``ValueError`` where fewer than ``BEYOND`` lie beyond it: it would hang on a few frames.
    """
    known = errors[~np.isnan(errors)]
    if len(known) < 20 * BEYOND:
        raise ValueError(f"frames.train: {len(known)} frames that count are too few for a 95th percentile")
    return float(np.quantile(known, 0.95))


@dataclass(frozen=True)
class _Place:
    """Where a sample comes from; ``frames`` is known by folder and definition."""

    folder: Path
    definition: str
    part: Part
    number: int
    base: TfraDesign
    frames: FrameSet = field(compare=False)


@lru_cache(maxsize=BLOCKS_IN_MEMORY)
def _sample(place: _Place) -> Sample:
    """Made once in each process that measures, since the float steps take longer than a design's own."""
    return Sample.of(place.base, place.frames.block(place.part, place.number))
