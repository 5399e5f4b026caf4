"""Events of frames in the core, and their cycles."""

from __future__ import annotations

from dataclasses import dataclass, field

from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.forces import PLANES
from tfra.hdl.parallel.tfra.plan import PLAN
from tfra.hdl.parallel.tfra.timeline.blocks import BlockCycles
from tfra.model.fixed.design import Design

NEVER = 1 << 62


@dataclass
class Span:
    """A unit works on a frame: ``what`` from the cycle ``start`` until before ``end``."""

    unit: str
    what: str
    frame: int
    start: int
    end: int


@dataclass
class Frame:
    """Cycles of one frame's events, in dataflow order."""

    taxel: int = 0
    direction: int = 0
    b: int = 0
    """Last quad of the folded stress at the matrix-vector unit."""
    n: int = 0
    sums_b: int = 0
    affine: int = 0
    residual: int = 0
    """Last beat of d2 at the vector updates."""
    e1: int = 0
    normal: list[int] = field(default_factory=list)
    """Quads of p and q at the queue of the sweep."""
    index: int = 0
    chosen: int = 0
    total: int = 0
    gain: int = 0
    force: list[int] = field(default_factory=list)
    """Quads of products at the vector updates."""
    words: list[int] = field(default_factory=list)
    """Every result word."""


@dataclass
class Vector:
    """An operand that the updates have made: the cycle of its last quad at its bank; d gives forces."""

    last: int
    is_d: bool
    frame: int


class Tokens:
    """``number`` at first; the others when they are given back."""

    def __init__(self, number: int) -> None:
        self._times, self._taken = [0] * number, 0

    def give(self, cycle: int) -> None:
        """Give one back; it can be seen in the next cycle."""
        self._times.append(cycle + 1)

    def seen(self) -> int:
        """First known cycle in which the next token is visible."""
        return self._times[self._taken] if self._taken < len(self._times) else NEVER

    def take(self) -> None:
        """Take the next one."""
        self._taken += 1


class Events:
    """State that the units' parts of the timeline share."""

    def __init__(self, design: Design, blocks: BlockCycles, frames: int) -> None:
        self.design, self.blocks = design, blocks
        self.frames = [Frame() for _ in range(frames)]
        self.spans: list[Span] = []
        self.vectors: list[Vector] = []
        self.residuals = 0
        """Residual products so far."""
        self.force_beats: set[int] = set()
        """Cycles in which products of forces enter the vector updates."""
        self.frame_tokens = Tokens(FRAMES)
        self.weight_tokens = Tokens(PLAN.source("residual").banks)
        self.bank_tokens = Tokens(PLAN.source("normal").banks)
        self.plane_tokens = Tokens(PLANES // 3)

    def before(self, number: int) -> Frame | None:
        """The frame before frame ``number``."""
        return self.frames[number - 1] if number else None
