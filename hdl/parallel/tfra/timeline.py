"""When things happen in the core: the events of frames that follow each other, cycle by cycle as in the gateware.

Every block takes a fixed number of cycles, whatever the data.  Two units decide what to do next among what is there:
the matrix-vector unit chooses a product, the vector updates begin a vector.  Decisions are taken here in the order of
their cycles, since nothing that follows from one can be seen before the cycle after it; everything else follows from
its inputs frame by frame.  Cycle numbers are those of the clock edge of a transfer, or of the cycle in which a state is
seen, with taxels always there and results always taken.
"""

from __future__ import annotations

import gc
import warnings
from dataclasses import dataclass, field

from amaranth.hdl import UnusedElaboratable

from tfra.hdl.lib.streams import Buffer, PerFrameQueue, Router
from tfra.hdl.parallel.gain import Gain
from tfra.hdl.parallel.matvec.drain import drain_latency, drain_steps, drain_words
from tfra.hdl.parallel.matvec.images import passes
from tfra.hdl.parallel.matvec.schedule import spacing
from tfra.hdl.parallel.matvec.unit import BANKS, CAPTURE, CHOICE, FULL, MatVec, full
from tfra.hdl.parallel.normaliser import Normaliser
from tfra.hdl.parallel.scaling import Scaling
from tfra.hdl.parallel.tfra.centroids import Centroids
from tfra.hdl.parallel.tfra.combine.store import FRAMES, MEASURE
from tfra.hdl.parallel.tfra.combine.unit import Combine
from tfra.hdl.parallel.tfra.dependent import Dependent
from tfra.hdl.parallel.tfra.forces import PLANES, Forces
from tfra.hdl.parallel.tfra.friction import Friction
from tfra.hdl.parallel.tfra.resultant import Resultant
from tfra.hdl.parallel.tfra.sums_queue import SumsQueue
from tfra.hdl.parallel.tfra.sweep.unit import Sweep
from tfra.hdl.parallel.tfra.weights import Weights
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
    """Cycles of one frame's events, in the order of the data."""

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


class _Tokens:
    """``number`` at first; the others when they are given back."""

    def __init__(self, number: int) -> None:
        self._times, self._taken = [0] * number, 0

    def give(self, cycle: int) -> None:
        self._times.append(cycle + 1)

    def seen(self) -> int:
        """Cycle from which the next one can be seen, as far as is known."""
        return self._times[self._taken] if self._taken < len(self._times) else NEVER

    def take(self) -> None:
        self._taken += 1


@dataclass(frozen=True)
class BlockCycles:
    """Cycles of the blocks, as they state them themselves: latencies, if nothing else is said."""

    normaliser: int
    centroids: int
    weights: int
    dependent: int
    combine: int
    sweep: int
    turn: int
    """From e0's last quad at the sweep's queue to the first of e1 that it can take."""
    e0: int
    """Between quads of e0 at the sweep."""
    quad: int
    """Between quads of e1 at the sweep."""
    frame_interval: int
    """Between frames at the sweep."""
    friction: int
    resultant: int
    gain: int
    scaling: int
    plane: int
    """From a plane's last force product to its first result word."""
    read: int
    """From reading a force to its result word."""
    busy: int
    """In which the lanes multiply, of a frame."""

    @classmethod
    def of(cls, design: Design) -> BlockCycles:
        """Ask every block of ``design``."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnusedElaboratable)
            found = cls._ask(design)
            gc.collect()  # a block that is only asked, not elaborated, complains when it goes: let it go here
        return found

    @classmethod
    def _ask(cls, design: Design) -> BlockCycles:
        combine, sweep, forces, scaling = Combine(design), Sweep(design), Forces(design), Scaling(design)
        return cls(
            normaliser=Normaliser(design).latency,
            centroids=Centroids(design).latency,
            weights=Weights(design).latency,
            dependent=Dependent(design).latency,
            combine=combine.force_latency,
            sweep=sweep.latency,
            turn=sweep.turn,
            e0=sweep.e0_interval,
            quad=sweep.quad_interval,
            frame_interval=sweep.frame_interval,
            friction=Friction(design).latency,
            resultant=Resultant(design).latency,
            gain=Gain(design).latency,
            scaling=scaling.latency,
            plane=combine.force_latency + forces.latency + scaling.force_latency,
            read=scaling.force_latency + forces.read_latency,
            busy=MatVec(design).busy_cycles,
        )


class Timeline:
    """The events of ``frames`` frames whose taxels come back to back; the first frame's last taxel comes in cycle 0."""

    def __init__(self, design: Design, blocks: BlockCycles, frames: int) -> None:
        self.design, self.wait = design, blocks
        self.frames = [Frame() for _ in range(frames)]
        self.spans: list[Span] = []
        self._stacks = {name: stack.quads for name, stack in design.stacks.items()}
        self._launched: list[int] = []
        self._drained: list[int] = []
        self._choice_from = -NEVER
        self._begin_from = -NEVER
        self._swept = -NEVER
        self._step_candidates = self._step_update = -NEVER
        self._vectors: list[tuple[int, bool, int]] = []  # last transfer, force, frame
        self._next = {"contact": 0, "residual": 0, "vector": 0, "e": 0, "d": 0}
        self._second = False
        self._tokens = {
            "frame": _Tokens(FRAMES),
            "n": _Tokens(BANKS["n"]),
            "bank": _Tokens(BANKS["vector"]),
            "plane": _Tokens(PLANES // 3),
        }
        self._b_free = 0
        self._quad_left = -NEVER
        self._folded: list[tuple[int, int]] = []  # moved to the fold's second register, left it
        self._entered: set[int] = set()
        self._input(0)
        while self._step():
            pass

    def _step(self) -> bool:
        """The earlier of the next two decisions; false at the end."""
        choice, begin = self._choice(), self._begin()
        if min(choice[0], begin[0]) >= NEVER:
            return False
        if choice[0] <= begin[0]:
            self._product(*choice)
        else:
            self._vector(*begin)
        return True

    # --- input -----------------------------------------------------------------------------------------------------

    def _input(self, number: int) -> None:
        """Taxels, normaliser and fold, once the operand's bank is known to be free."""
        if number == len(self.frames):
            return
        f, m, q, wait = self.frames[number], self.design.sensor.taxels, self.design.quads, self.wait
        normaliser = centroids = 0
        if number:
            # Both take the last taxel when the frame before has left them, each at its own time.
            before = self.frames[number - 1]
            normaliser = max(before.taxel + m, self._quad_left + 1)
            centroids = max(before.taxel + m, before.direction + 1)
        f.taxel = max(normaliser, centroids)
        f.direction = centroids + wait.centroids
        left = normaliser + wait.normaliser - 1
        for _ in range(q):
            left = self._fold(left + 1)
        self._quad_left, f.b = left, self._folded[-1][1]

    def _fold(self, cycle: int) -> int:
        """A quad through the fold: the cycle in which it enters, at ``cycle`` or later.

        Both registers wait while the second one does, even if the first is empty.
        """
        for reached, sent in self._folded[-2:]:
            if reached < cycle < sent:
                cycle = sent
        reached = cycle + 1
        if self._folded and self._folded[-1][0] < reached < self._folded[-1][1]:
            reached = self._folded[-1][1]
        self._folded.append((reached, max(reached + 1, self._b_free)))
        return cycle

    # --- the matrix-vector unit ------------------------------------------------------------------------------------

    def _choice(self) -> tuple[int, str, int]:
        """Cycle of the next choice, the stack, and the frame."""
        wanted = []
        if self._next["vector"] < len(self._vectors):
            last, force, frame = self._vectors[self._next["vector"]]
            leave = self._tokens["plane"].seen() if force else 0
            wanted.append((max(last + FULL, leave), "force" if force else "normal", frame))
        for stack, operand in (("residual", "n"), ("contact", "b")):
            number = self._next[stack]
            there = number < len(self.frames) and (stack == "contact" or number < self._next["contact"])
            if there:
                leave = max(self._tokens["frame"].seen(), self._tokens["n"].seen()) if stack == "contact" else 0
                seen = getattr(self.frames[number], operand) + full(self.design, stack)
                wanted.append((max(seen, leave), stack, number))
        if not wanted:
            return NEVER, "", 0
        cycle = max(self._choice_from, min(w[0] for w in wanted))
        return next((cycle, stack, frame) for seen, stack, frame in wanted if seen <= cycle)

    def _product(self, cycle: int, stack: str, number: int) -> None:
        """All passes of a product, and where its results go."""
        times = passes(self.design, stack)
        captured = [self._launch(cycle + CHOICE) for _ in range(times)]
        launches, lanes = self._launched[-times:], self.design.architecture.mac_lanes
        self._choice_from = launches[-1] + 2
        results = []
        for quad in range(self._stacks[stack]):
            turn, row = divmod(4 * quad + 3, lanes)
            leave = row // drain_words(self.design) + drain_latency(self.design)
            results.append(captured[turn] + leave + Router.latency)
        q = self.design.quads
        self.spans.append(Span("matvec", stack, number, launches[0] + 1, launches[-1] + 1 + q))
        getattr(self, f"_after_{stack}")(number, launches[-1], results)

    def _launch(self, ready: int) -> int:
        """Launch the next pass, not before cycle ``ready``, and return the cycle in which its sums are captured.

        It waits for the pass before, and for the one before that to have left the drain register.
        """
        launch = ready
        if self._launched:
            launch = max(launch, self._launched[-1] + spacing(self.design))
        if len(self._drained) > 1:
            launch = max(launch, self._drained[-2] + 1)
        capture = launch + self.design.quads + CAPTURE
        self._launched.append(launch)
        self._drained.append(capture + drain_steps(self.design))
        return capture

    def _after_contact(self, number: int, last: int, results: list[int]) -> None:
        f, q = self.frames[number], self.design.quads
        self._tokens["frame"].take()
        self._tokens["n"].take()
        f.n, f.sums_b = results[q - 1] + self.wait.weights, results[q]
        self._next["contact"] += 1
        self._b_free = last + 2
        self._input(number + 1)

    def _after_residual(self, number: int, last: int, results: list[int]) -> None:
        f = self.frames[number]
        self._tokens["n"].give(last + 1)
        self._next["residual"] += 1
        f.residual = results[-1] + self.design.cycles_per_quad - 1
        taken = max(f.sums_b + SumsQueue.latency, self.frames[number - 1].affine + 1 if number else 0)
        for cycle in results[:3]:
            taken = max(cycle + SumsQueue.latency, taken + SumsQueue.interval)
        f.affine = max(taken, f.direction + Buffer.latency + PerFrameQueue.latency - 1) + self.wait.dependent
        self.spans.append(Span("dependent", "alpha, beta", number, taken, f.affine))

    def _after_normal(self, number: int, last: int, results: list[int]) -> None:
        f = self.frames[number]
        self._tokens["bank"].give(last + 1)
        self._next["vector"] += 1
        f.normal += [cycle + self.design.cycles_per_quad - 1 for cycle in results]
        if len(f.normal) == 2 * self.design.quads:
            self._sweep(number)

    def _after_force(self, number: int, last: int, results: list[int]) -> None:
        f = self.frames[number]
        self._tokens["bank"].give(last + 1)
        self._tokens["plane"].take()
        self._next["vector"] += 1
        beats = self.design.cycles_per_quad
        f.force = [cycle + beats - 1 for cycle in results]
        self._entered |= {cycle + beat for cycle in results for beat in range(beats)}
        self._tokens["frame"].give(f.force[-1] + 1)
        self.spans.append(Span("combine", "forces", number, results[0], f.force[-1] + 1))
        self._words(number)

    # --- the vector updates ----------------------------------------------------------------------------------------

    def _begin(self) -> tuple[int, str, int]:
        """Cycle in which the next vector is begun, its name, and the frame."""
        ready = []
        d, e = self._next["d"], self._next["e"]
        if d < e and self.frames[d].chosen:
            f = self.frames[d]
            ready.append((max(f.chosen + PerFrameQueue.latency + 1, f.e1 + MEASURE, self._step_update), "d", d))
        if e < self._next["residual"]:
            f = self.frames[e]
            facts = max(f.affine, f.direction) + Buffer.latency + PerFrameQueue.latency + 1
            ready.append((max(f.residual + MEASURE, facts, self._step_candidates), "e1" if self._second else "e0", e))
        if not ready:
            return NEVER, "", 0
        cycle = max(self._begin_from, min(r[0] for r in ready), self._tokens["bank"].seen())
        return next((cycle, name, frame) for seen, name, frame in ready if seen <= cycle)

    def _vector(self, cycle: int, name: str, number: int) -> None:
        """Beats of a vector enter where none of a product does."""
        f, entry = self.frames[number], cycle
        first = 0
        self._tokens["bank"].take()
        for beat in range(self.design.quads * self.design.cycles_per_quad):
            entry += 1
            while entry in self._entered:
                entry += 1
            first = first if beat else entry
        self._begin_from = entry + 1
        out = entry + self.wait.combine
        self._vectors.append((out, name == "d", number))
        self.spans.append(Span("combine", name, number, first, entry + 1))
        if name == "d":
            self._next["d"] += 1
            self._step_update = entry + 3
        else:
            self._second = name == "e0"
        if name == "e1":
            self._next["e"] += 1
            self._step_candidates = entry + 3
            f.e1 = out - 1

    # --- behind the products ---------------------------------------------------------------------------------------

    def _sweep(self, number: int) -> None:
        """The index and what follows from it: friction, resultant, gain."""
        f, wait = self.frames[number], self.wait
        before = self.frames[number - 1] if number else None
        quads = self.design.quads
        entered = self._swept + wait.quad - wait.e0
        for cycle in f.normal[:quads]:
            entered = max(cycle, entered + wait.e0)
        start = entered = max(entered + wait.turn - wait.quad, self._swept + wait.frame_interval - wait.quad)
        for cycle in f.normal[quads:]:
            entered = max(cycle, entered + wait.quad)
        self._swept = entered
        f.index = entered + wait.sweep
        self.spans.append(Span("sweep", "candidates", number, start + wait.quad, f.index))
        f.chosen = f.index + wait.friction
        begin = f.chosen + PerFrameQueue.latency
        if before:
            begin = max(begin, before.total + 1)
        f.total = begin + wait.resultant
        begin = f.total + PerFrameQueue.latency
        if before:
            begin = max(begin, before.gain + 2)
        f.gain = begin + wait.gain
        self.spans.append(Span("gain", "gain", number, begin, f.gain))

    def _words(self, number: int) -> None:
        """Result words: the header behind the gain, forces as their planes come, never two in a cycle."""
        f, m, q, wait = self.frames[number], self.design.sensor.taxels, self.design.quads, self.wait
        cycle = f.gain + PerFrameQueue.latency + wait.scaling - 1
        if number:
            cycle = max(cycle, self.frames[number - 1].words[-1] + 2)
        header = next(row.start for row in self.design.layout if row.name == "forces")
        for word in range(self.design.frame_words):
            cycle += 1
            plane, taxel = divmod(word - header, m)
            if taxel == 0 and 0 <= plane < 3:
                cycle = max(cycle, f.force[(plane + 1) * q - 1] + wait.plane)
            f.words.append(cycle)
        self._tokens["plane"].give(f.words[header + 3 * m - 1] - wait.read + 1)
        self.spans.append(Span("scaling", "result", number, f.words[0], f.words[-1] + 1))
