"""Latency and initiation interval of a design, from the timeline of its frames."""

from __future__ import annotations

from functools import cached_property

from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.timeline import Timeline, cycles
from tfra.model.design import Design

SETTLED = 12
"""Frames after which the times between frames have settled; as many again are averaged."""

ENOUGH = 2 * SETTLED + 2 * FRAMES
"""Frames that show the interval: the last ones meet no others, so that they are not looked at."""


class Timing:
    """Latency and initiation interval of a design, in cycles."""

    def __init__(self, design: Design) -> None:
        self.design = design

    @cached_property
    def alone(self) -> Timeline:
        """A single frame in an idle core."""
        return Timeline(self.design, 1)

    @cached_property
    def stream(self) -> Timeline:
        """Frames back to back."""
        return Timeline(self.design, ENOUGH)

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
    def multiplications(self) -> int:
        """Real products of a frame in the matrix-vector unit."""
        return int(cycles(self.design).multiplications)

    @property
    def utilisation(self) -> float:
        """Part of the cycles in which the lanes multiply, frames back to back."""
        return float(cycles(self.design).busy) / self.initiation_interval
