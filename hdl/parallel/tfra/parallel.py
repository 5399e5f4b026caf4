"""The parallel microarchitecture of TFRA."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel.matvec.images import busy_cycles
from tfra.hdl.parallel.matvec.microarchitecture import ParallelCore
from tfra.hdl.parallel.tfra.core import Core
from tfra.hdl.parallel.tfra.probes import probes
from tfra.hdl.parallel.tfra.timeline.blocks import BlockCycles
from tfra.hdl.parallel.tfra.timeline.timeline import Timeline
from tfra.model.fixed.design import Design


class Parallel(ParallelCore[Design, Timeline]):
    """The core of blocks that stream to each other."""

    def build(self) -> Core:
        """The core."""
        return Core(self.design)

    @cached_property
    def blocks(self) -> BlockCycles:
        """Cycles of the blocks, as they state them themselves."""
        return BlockCycles.of(self.design)

    def timeline(self, frames: int) -> Timeline:
        """``frames`` frames back to back."""
        return Timeline(self.design, self.blocks, frames)

    @property
    def utilisation(self) -> float:
        """Share of the cycles in which the lanes multiply, frames back to back."""
        return self.blocks.busy / self.initiation_interval

    def choices(self) -> Iterator[Parallel]:
        """This core with every number of lanes that the sensor allows, upwards.

        Lanes change the cycles of the products alone, so that those of the other blocks are asked for once.
        """
        for lanes in self.lane_choices:
            core = Parallel(self.design.built_as(replace(self.design.architecture, mac_lanes=lanes)))
            core.blocks = replace(self.blocks, busy=busy_cycles(core.design))
            yield core

    @property
    def probes(self) -> tuple[Probe, ...]:
        """Streams between blocks that a simulation may watch, in the order in which data reach them."""
        return probes(self.design)
