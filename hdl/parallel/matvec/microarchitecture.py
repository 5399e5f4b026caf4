"""What the parallel cores of all estimators have in common: lanes with coefficients, and a timeline of frames."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from tfra.hdl.interface.microarchitecture import Probe
from tfra.hdl.parallel.matvec.images import depth, lane_images
from tfra.hdl.primitives import cell_models
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design

SETTLED = 12
"""Frames after which the times between frames have settled; as many again are averaged."""

ENOUGH = 2 * SETTLED + 8
"""Frames of a simulation that show the interval; the last ones, twice as many as are in flight, are ignored, because no
others follow them."""


class Frame(Protocol):
    """A frame of a timeline; the first one's last taxel comes in cycle 0."""

    @property
    def words(self) -> list[int]:
        """The cycle of every result word."""


class Timeline(Protocol):
    """Events of consecutive frames that never wait at the ports."""

    @property
    def frames(self) -> Sequence[Frame]:
        """The frames in order."""


D = TypeVar("D", bound=Design)
T = TypeVar("T", bound=Timeline)


class ParallelCore(ABC, Generic[D, T]):
    """:class:`tfra.hdl.interface.microarchitecture.Microarchitecture` of blocks; frames interleave in them."""

    settled = slice(SETTLED, 2 * SETTLED)
    enough = ENOUGH

    def __init__(self, design: D) -> None:
        self.design = design

    @abstractmethod
    def build(self) -> Any:
        """The core."""

    @abstractmethod
    def timeline(self, frames: int) -> T:
        """``frames`` frames back to back."""

    @property
    @abstractmethod
    def probes(self) -> tuple[Probe, ...]:
        """Streams between blocks that a simulation may watch, in the order in which data reach them."""

    def check(self) -> None:
        """Raise ``ValueError`` for words that can overflow."""
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
    def lanes(self) -> int:
        """Multiply-accumulate lanes."""
        return self.design.architecture.mac_lanes

    @property
    def lane_choices(self) -> tuple[int, ...]:
        """Numbers of lanes that the sensor allows, ascending."""
        return tuple(range(4, 4 * self.design.quads + 1, 4))

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
