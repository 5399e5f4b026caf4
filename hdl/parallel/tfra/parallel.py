"""The parallel microarchitecture: blocks that stream to each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel.matvec.images import busy_cycles, depth, lane_images
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.core import Core
from tfra.hdl.parallel.tfra.probes import probes
from tfra.hdl.parallel.tfra.timeline.blocks import BlockCycles
from tfra.hdl.parallel.tfra.timeline.timeline import Timeline
from tfra.hdl.primitives import cell_models
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

SETTLED = 12
"""Frames after which the times between frames have settled; as many again are averaged."""

ENOUGH = 2 * SETTLED + 2 * FRAMES
"""Frames of a simulation that show the interval; the last ones are ignored, because no others follow them."""


class Parallel:
    """:class:`tfra.hdl.interface.microarchitecture.Microarchitecture` of blocks; frames interleave in them."""

    settled = slice(SETTLED, 2 * SETTLED)
    enough = ENOUGH

    def __init__(self, design: Design) -> None:
        self.design = design

    def check(self) -> None:
        """Raise ``ValueError`` for words that can overflow."""
        _ = self.design.widths

    def build(self) -> Core:
        """The core."""
        return Core(self.design)

    @cached_property
    def blocks(self) -> BlockCycles:
        """Cycles of the blocks, as they state them themselves."""
        return BlockCycles.of(self.design)

    @cached_property
    def alone(self) -> Timeline:
        """A single frame in an idle core."""
        return self.timeline(1)

    @cached_property
    def stream(self) -> Timeline:
        """Frames back to back."""
        return self.timeline(ENOUGH)

    def timeline(self, frames: int) -> Timeline:
        """``frames`` frames back to back."""
        return Timeline(self.design, self.blocks, frames)

    @property
    def latency(self) -> int:
        """Cycles from the last taxel of a frame to its first result word, the core being idle."""
        return self.alone.frames[0].words[0]

    @property
    def frame_latency(self) -> int:
        """Cycles from the last taxel of a frame to its last result word, the core being idle."""
        return self.alone.frames[0].words[-1]

    @cached_property
    def initiation_interval(self) -> int:
        """Cycles from one frame to the next when frames come back to back: the mean of twelve, rounded up.

        Frames interleave, so that the times between single ones differ.
        """
        frames = self.stream.frames
        return -(-(frames[2 * SETTLED].words[-1] - frames[SETTLED].words[-1]) // SETTLED)

    @property
    def utilisation(self) -> float:
        """Share of the cycles in which the lanes multiply, frames back to back."""
        return self.blocks.busy / self.initiation_interval

    @property
    def lanes(self) -> int:
        """Multiply-accumulate lanes."""
        return self.design.architecture.mac_lanes

    @property
    def lane_choices(self) -> tuple[int, ...]:
        """Numbers of lanes that the sensor allows, ascending."""
        return tuple(range(4, 4 * self.design.quads + 1, 4))

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

    @property
    def cell_models(self) -> tuple[Path, ...]:
        """Verilog files with models of the cells that the core instantiates."""
        return cell_models(self.design.target)

    @cached_property
    def coefficients(self) -> Ints:
        """Words ``(lanes, depth)`` of the lanes' memories in the order in which they are read."""
        return lane_images(self.design)

    @property
    def loaded(self) -> Ints | None:
        """Coefficients in the order in which the core loads them after a reset; None if it loads none."""
        return self.coefficients.ravel() if self.design.images == "load" else None

    @property
    def load_order(self) -> str:
        """That order, described in text."""
        return f"for each of {self.lanes} MAC lanes the {depth(self.design)} words that it reads, in that order"
