"""When things happen in the core: latency and initiation interval from the schedule of the products.

Every block takes a fixed number of cycles, whatever the data, so the times of a frame's events follow from each
other; where two things must have happened, the later one counts.  Cycle numbers are those of the clock edge at
which a transfer takes place, with inputs always there and results always taken.
"""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from amaranth.hdl import UnusedElaboratable

from tfra.codegen.images import passes
from tfra.hdl.centroids import Centroids
from tfra.hdl.combine import Combine
from tfra.hdl.dependent import Dependent
from tfra.hdl.forces import Forces
from tfra.hdl.friction import Friction
from tfra.hdl.gain import Gain
from tfra.hdl.matvec import CAPTURE, DRAIN, FULL, MatVec
from tfra.hdl.normaliser import Normaliser
from tfra.hdl.resultant import Resultant
from tfra.hdl.scaling import Scaling
from tfra.hdl.streams import Buffer, Queue
from tfra.hdl.sweep import Sweep
from tfra.hdl.weights import Weights
from tfra.model.design import Design
from tfra.model.fixed.coefficients import stacks
from tfra.model.fixed.words import frame_words, layout

_FRAMES = 12
"""Frames after which the times between them have settled."""

_FOLD = 2  # the butterfly's two levels


class Products:
    """Times of the matrix-vector unit, pass by pass (:class:`tfra.hdl.matvec.MatVec`)."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self._launched: list[int] = []
        self._drained: list[int] = []
        self._leaving = max(1, design.architecture.mac_lanes // 4)

    def run(self, stack: str, operand: int) -> list[int]:
        """Cycle of each result quad of ``stack`` when its operand's last quad comes in cycle ``operand``."""
        captured = [self._launch(operand + FULL) for _ in range(passes(self.design, stack))]
        results = []
        for quad in range(stacks(self.design)[stack].quads):
            turn, row = divmod(4 * quad + 3, self.design.architecture.mac_lanes)
            results.append(captured[turn] + DRAIN + row // 4)
        return results

    def _launch(self, ready: int) -> int:
        """Launch the next pass, not before cycle ``ready``, and return the cycle in which its sums are captured.

        It waits for the reads of the pass before, and for the pass before that to have left the drain register.
        """
        q = self.design.quads
        launch = ready
        if self._launched:
            launch = max(launch, self._launched[-1] + q)
        if len(self._drained) > 1:
            launch = max(launch, self._drained[-2] + 1)
        capture = max(launch + q + CAPTURE, self._drained[-1] if self._drained else 0)
        self._launched.append(launch)
        self._drained.append(capture + self._leaving)
        return capture


@dataclass
class Frame:
    """Cycles of one frame's events: its last taxel, then transfers in the order of the data."""

    taxel: int
    b: int = 0
    """Last quad of the folded stress at the matrix-vector unit."""
    n: int = 0
    affine: int = 0
    e1: int = 0
    index: int = 0
    chosen: int = 0
    d: int = 0
    gain: int = 0
    words: list[int] = field(default_factory=list)
    """Every result word."""


class Timing:
    """Latency and initiation interval of a design, in cycles."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self._cycles = _latencies(design)

    @cached_property
    def frame(self) -> Frame:
        """The events of a single frame; its last taxel comes in cycle 0."""
        return self._frame(Products(self.design), None)

    @property
    def latency(self) -> int:
        """Cycles from the last taxel of a frame to its first result word, the core being idle."""
        return self.frame.words[0]

    @property
    def frame_latency(self) -> int:
        """Cycles from the last taxel of a frame to its last result word, the core being idle."""
        return self.frame.words[-1]

    @cached_property
    def initiation_interval(self) -> int:
        """Cycles from one frame to the next when frames come back to back: the mean of two, rounded up."""
        products = Products(self.design)
        frames: list[Frame] = []
        for _ in range(_FRAMES):
            frames.append(self._frame(products, frames[-1] if frames else None))
        return -(-(frames[-1].words[-1] - frames[-3].words[-1]) // 2)

    @property
    def multiplications(self) -> int:
        """Real products of a frame in the matrix-vector unit."""
        return self._cycles["multiplications"]

    def _frame(self, products: Products, before: Frame | None) -> Frame:
        """Events of the frame behind ``before``, whose taxels are all there already."""
        q, wait = self.design.quads, self._cycles
        f = Frame(taxel=0)
        f.b = wait["normaliser"] + _FOLD + q - 1
        if before:
            # The fold's operand stands behind the last product's in the queue for the unit.
            f.b = max(f.b, before.d + q)
        contact = products.run("contact", f.b)
        f.n = contact[q - 1] + wait["weights"]
        residual = products.run("residual", f.n)
        f.affine = max(residual[-1], wait["centroids"] - 1) + wait["dependent"]
        e0 = f.affine + wait["combine"] + q - 1
        f.e1 = e0 + q
        p = products.run("normal", e0)
        f.index = self._sweep(p, products.run("normal", f.e1))
        f.chosen = f.index + wait["friction"]
        f.d = f.chosen + wait["update"] + q - 1
        force = products.run("force", f.d)
        f.gain = max(f.chosen + wait["resultant"], before.gain + 1 if before else 0) + wait["gain"]
        f.words = self._words(f, force, before)
        return f

    def _sweep(self, p: list[int], q: list[int]) -> int:
        """Cycle of the index: quads of q are taken from the queue one by one, as the taxels run."""
        taken = p[-1] + self._cycles["queue"] + 1
        for cycle in q:
            taken = max(cycle + self._cycles["queue"], taken + (1 if cycle == q[0] else self._cycles["quad"]))
        return taken + self._cycles["sweep"]

    def _words(self, f: Frame, force: list[int], before: Frame | None) -> list[int]:
        """Result words: the header behind the gain, forces as their planes come, never two in a cycle."""
        m, q, wait = self.design.sensor.taxels, self.design.quads, self._cycles
        cycle = f.gain + Buffer.latency + wait["scaling"] - 1
        if before:
            cycle = max(cycle, before.words[-1])
        words = []
        header = next(row.start for row in layout(self.design) if row.name == "forces")
        for number in range(frame_words(self.design)):
            cycle += 1
            plane, taxel = divmod(number - header, m)
            if taxel == 0 and 0 <= plane < 3:
                ready = force[(plane + 1) * q - 1] + wait["plane"]
                cycle = max(cycle, ready)
            words.append(cycle)
        return words


def _latencies(design: Design) -> dict[str, int]:
    """Cycles of the blocks, as they state them themselves."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        blocks: dict[str, Any] = {
            block.__name__.lower(): block(design)
            for block in (Normaliser, Centroids, Weights, MatVec, Dependent, Combine, Sweep, Friction, Resultant)
        }
        blocks |= {block.__name__.lower(): block(design) for block in (Gain, Forces, Scaling)}
        names = ("normaliser", "centroids", "weights", "dependent", "combine", "sweep", "friction", "resultant")
        cycles = {name: int(blocks[name].latency) for name in (*names, "gain", "scaling")}
        cycles["update"] = blocks["combine"].update_latency
        cycles["quad"] = blocks["sweep"].quad_interval
        cycles["queue"] = Queue.latency
        cycles["plane"] = blocks["combine"].force_latency + blocks["forces"].latency + blocks["scaling"].force_latency
        cycles["multiplications"] = blocks["matvec"].multiplications
        del blocks
        gc.collect()  # a block that is only asked, not elaborated, complains when it goes: let it go here
    return cycles
