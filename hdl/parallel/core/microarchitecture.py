"""What the parallel cores of all estimators have in common: lanes with coefficients, and a timeline of frames."""

from abc import ABC
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel.core.core import Core, CoreBlocks, ask_blocks
from tfra.hdl.parallel.core.timeline import Frame, Timeline
from tfra.hdl.parallel.matvec.images import depth, lane_images
from tfra.hdl.primitives import cell_models
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

SETTLED = 12
"""Frames after which the times between frames have settled; as many again are averaged."""

ENOUGH = 2 * SETTLED + 8
"""Frames of a simulation that show the interval; the last ones, twice as many as are in flight, are ignored, because no
others follow them."""

D = TypeVar("D", bound=Design)
T = TypeVar("T", bound=Timeline[Frame])


class Parallel(ABC, Generic[D, T]):
    """:class:`tfra.hdl.interface.microarchitecture.Microarchitecture` of blocks; frames interleave in them.

    What others ask of it is described there.
    """

    settled = slice(SETTLED, 2 * SETTLED)
    enough = ENOUGH

    core: ClassVar[type[Core]]
    trace: ClassVar[Any]
    """Class of the timeline: of a design, the cycles of its blocks, and a number of frames."""

    def __init__(self, design: D) -> None:
        self.design = design

    def build(self) -> Core:
        return self.core(self.design)

    @cached_property
    def cycles(self) -> Mapping[str, int]:
        """Cycles of the blocks, as they state them themselves."""
        def stated(blocks: CoreBlocks) -> dict[str, int]:
            there = [name for name in self.trace.stated if hasattr(blocks, name.partition(".")[0])]
            return {name: attrgetter(name)(blocks) for name in there}

        return ask_blocks(lambda: self.core.blocks(self.design), stated)

    def timeline(self, frames: int) -> T:
        """``frames`` frames back to back."""
        timeline: T = self.trace(self.design, self.cycles, frames)
        return timeline

    @cached_property
    def probes(self) -> tuple[Probe, ...]:
        def watched(blocks: CoreBlocks) -> tuple[Probe, ...]:
            return tuple(each.probe(block) for each, block in self.core.watched_blocks(self.design, blocks))

        return ask_blocks(lambda: self.core.blocks(self.design), watched)

    def check(self) -> None:
        _ = self.design.widths

    @cached_property
    def alone(self) -> T:
        """A single frame in an idle core."""
        return self.timeline(1)

    @cached_property
    def stream(self) -> T:
        """Frames back to back."""
        return self.timeline(ENOUGH)

    @property
    def intake(self) -> int:
        return self.design.sensor.taxels - 1

    @property
    def latency(self) -> int:
        return self.alone.frames[0].words[0]

    @property
    def frame_latency(self) -> int:
        return self.alone.frames[0].words[-1]

    @property
    def initiation_interval(self) -> int:
        """The mean of twelve, rounded up: frames interleave, so that the times between single ones differ."""
        return -(-sum(self.intervals) // SETTLED)

    @cached_property
    def intervals(self) -> list[int]:
        ends = [frame.words[-1] for frame in self.stream.frames[SETTLED : 2 * SETTLED + 1]]
        return [end - before for before, end in pairwise(ends)]

    def queued(self, ahead: int) -> tuple[int, int]:
        before = self.stream.frames[self.settled]
        frames = self.stream.frames[SETTLED + ahead :]
        waits = [[word - first.taxel for word in frame.words] for first, frame in zip(before, frames, strict=False)]
        return max(words[0] for words in waits), max(words[-1] for words in waits)

    @property
    def lanes(self) -> int:
        return self.design.architecture.mac_lanes

    @property
    def lane_choices(self) -> tuple[int, ...]:
        return tuple(range(4, 4 * self.design.quads + 1, 4))

    def choices(self) -> "Iterator[Parallel[D, T]]":
        """Lanes change the cycles of the products alone, so that those of the blocks are asked for once."""
        for lanes in self.lane_choices:
            core = type(self)(self.design.built_as(replace(self.design.architecture, mac_lanes=lanes)))
            core.cycles = self.cycles
            yield core

    @property
    def cell_models(self) -> tuple[Path, ...]:
        return cell_models(self.design.target, "multiplier", "rom")

    @cached_property
    def coefficients(self) -> Ints:
        """Words ``(lanes, depth)`` of the lanes' memories in the order in which they are read."""
        return lane_images(self.design)

    @property
    def loaded(self) -> Ints | None:
        return self.coefficients.ravel() if self.design.images == "load" else None

    @property
    def load_order(self) -> str:
        return f"for each of {self.lanes} MAC lanes the {depth(self.design)} words that it reads, in that order"
