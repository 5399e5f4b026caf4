"""The parallel microarchitecture of the learned estimator."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel.learned.core import LearnedCore
from tfra.hdl.parallel.learned.cycles import Cycles
from tfra.hdl.parallel.learned.probes import probes
from tfra.hdl.parallel.learned.timeline import Timeline
from tfra.hdl.parallel.matvec.microarchitecture import ParallelCore
from tfra.model.fixed.learned.design import LearnedDesign


class LearnedParallel(ParallelCore[LearnedDesign, Timeline]):
    """The core of blocks that stream to each other."""

    def build(self) -> LearnedCore:
        """The core."""
        return LearnedCore(self.design)

    @cached_property
    def blocks(self) -> Cycles:
        """Cycles of the blocks, as they state them themselves."""
        return Cycles.of(self.design)

    def timeline(self, frames: int) -> Timeline:
        """``frames`` frames back to back."""
        return Timeline(self.design, self.blocks, frames)

    def choices(self) -> Iterator[LearnedParallel]:
        """This core with every number of lanes that the sensor allows, upwards; the blocks are asked for once."""
        for lanes in self.lane_choices:
            core = LearnedParallel(self.design.built_as(replace(self.design.architecture, mac_lanes=lanes)))
            core.blocks = self.blocks
            yield core

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Streams between blocks that a simulation may watch, in the order in which data reach them."""
        return probes(self.design)
