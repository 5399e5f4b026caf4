"""Engine of the timelines: the events of consecutive frames, cycle by cycle as in the gateware.

Every block takes a fixed number of cycles, independent of the data.  Units choose among available work: the
matrix-vector unit chooses a product, and an estimator may have others.  Decisions are followed in the order of their
cycles, since no effect of one is visible before the next cycle; all other events follow from their inputs frame by
frame.  A cycle number is that of the clock edge of a transfer, or of the cycle in which a state is visible.  Taxels are
always valid and results always ready.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, NamedTuple, Protocol, TypeVar

from tfra.hdl.parallel.matvec.passes import Passes, full
from tfra.hdl.parallel.matvec.plan import Plan
from tfra.model.fixed.design import Design

NEVER = 1 << 62
"""A cycle that does not come; its negative is before all others."""

BANK_FREE = 2
"""Cycles from a launch to the first quad of the next operand, or to the token of its bank: the bank is freed, then
seen."""

SEEN = 1
"""Cycles from an event to the first cycle in which its effect on a state is visible."""


@dataclass
class Frame:
    """Cycles of one frame's events, in dataflow order; an estimator adds its own."""

    taxel: int = 0
    """Its last one."""
    words: list[int] = field(default_factory=list)
    """Every result word."""


class Decision(NamedTuple):
    """What a unit does next, and in which cycle; ``NEVER`` if it has no work."""

    cycle: int
    act: Callable[[], None]


IDLE = Decision(NEVER, lambda: None)


class Unit(Protocol):
    """A unit that chooses among available work."""

    def decide(self) -> Decision:
        """Its next decision, as far as known."""


def visible(tokens: deque[int]) -> int:
    """First known cycle in which there is one of ``tokens``, each the cycle from which it can be seen."""
    return tokens[0] if tokens else NEVER


class Intake:
    """Frames of ``taxels`` taxels and ``quads`` quads through a normaliser of this ``latency``, and the fold."""

    def __init__(self, taxels: int, quads: int, latency: int) -> None:
        self._taxels, self._quads, self._latency = taxels, quads, latency
        self._last_quad = -NEVER
        """Of the frame before, out of the normaliser."""
        self._fold: list[tuple[int, int]] = []
        """Of every quad: the cycle in which it moves to the fold's second register, and in which it leaves that."""

    def last_taxel(self, before: int) -> int:
        """When the next frame's last taxel is taken, after that of the frame before, and after its last quad."""
        return max(before + self._taxels, self._last_quad + 1)

    def last_quad(self, taxel: int, bank_free: int) -> int:
        """When the last quad of a frame reaches b's bank, which takes quads from the cycle ``bank_free`` on."""
        entered = taxel + self._latency - 1
        for _ in range(self._quads):
            entered = self._enter_fold(entered + 1, bank_free)
        self._last_quad = entered
        return self._fold[-1][1]

    def _enter_fold(self, cycle: int, bank_free: int) -> int:
        """A quad through the fold: the cycle in which it enters, at ``cycle`` or later.

        Both registers wait while the second one does, even if the first is empty.
        """
        for reached, sent in self._fold[-2:]:
            if reached < cycle < sent:
                cycle = sent
        reached = cycle + 1
        if self._fold and self._fold[-1][0] < reached < self._fold[-1][1]:
            reached = self._fold[-1][1]
        self._fold.append((reached, max(reached + 1, bank_free)))
        return cycle


class _Operand(NamedTuple):
    """An operand at its buffer: the stack of its product, its frame, the cycle of its last quad."""

    stack: str
    frame: int
    last: int


class Products:
    """The matrix-vector unit: it chooses a product among the available operands, and runs its passes."""

    def __init__(self, timeline: "Timeline[Any]", plan: Plan) -> None:
        self._timeline, self._plan = timeline, plan
        self._passes = Passes(timeline.design)
        self.launches: list[tuple[int, str]] = []
        """Cycle and stack of every product's first launch."""
        self._operands: dict[str, deque[_Operand]] = {source.name: deque() for source in plan.sources}

    def add(self, stack: str, frame: int, last: int) -> None:
        """An operand of ``stack``, whose last quad comes in the cycle ``last``."""
        self._operands[self._plan.source(stack).name].append(_Operand(stack, frame, last))

    def decide(self) -> Decision:
        """The next product: of the first source in the plan that has one by then."""
        ready = [(self._ready(operands[0]), operands) for operands in self._operands.values() if operands]
        cycle = max(self._passes.next_choice, min((seen for seen, _ in ready), default=NEVER))
        if cycle >= NEVER:
            return IDLE
        chosen = next(operands for seen, operands in ready if seen <= cycle)
        return Decision(cycle, lambda: self._run(chosen.popleft(), cycle))

    def _ready(self, operand: _Operand) -> int:
        """First cycle in which the product of ``operand`` may be chosen: it is there, and so are its tokens."""
        there = operand.last + full(self._timeline.design, self._plan, operand.stack)
        return max([there, *(visible(token) for token in self._tokens(operand.stack))])

    def _tokens(self, stack: str) -> list[deque[int]]:
        return [self._timeline.tokens[name] for name in self._plan.needs.get(stack, ())]

    def _run(self, operand: _Operand, cycle: int) -> None:
        """All passes of a product that is chosen in ``cycle``, and what follows from them."""
        timeline, stack, frame = self._timeline, operand.stack, operand.frame
        for token in self._tokens(stack):
            token.popleft()
        launches, results = self._passes.product(stack, cycle)
        self.launches.append((launches[0], stack))
        for name, before in self._plan.follows.items():
            if before == stack:
                timeline.tokens[name].append(launches[0] + BANK_FREE)
        token_of_bank = self._plan.source(stack).token
        if token_of_bank:
            timeline.tokens[token_of_bank].append(launches[-1] + BANK_FREE)
        else:
            timeline.enter(frame + 1, launches[-1] + BANK_FREE)
        timeline.after(stack, frame, [quad + timeline.route_latency for quad in results])


F = TypeVar("F", bound=Frame, covariant=True)


class Timeline(ABC, Generic[F]):
    """The events of frames whose taxels come back to back; the first frame's last taxel comes in cycle 0.

    Arguments:
        design: its products are followed by the rules of ``plan``.
        cycles: by "BLOCK.PROPERTY", the cycles that blocks state.
        frames: one for each frame, to be filled.
        tokens: by name in the plan, how many there are of those that no source has.
    """

    stated: ClassVar[tuple[str, ...]]
    """Keys of ``cycles``: blocks that a design does not have are left out."""

    route_latency: ClassVar[int] = 0
    """Cycles from a result of the matrix-vector unit to its users."""

    def __init__(
        self, design: Design, plan: Plan, cycles: Mapping[str, int], frames: list[F], tokens: Mapping[str, int]
    ) -> None:
        self.design, self.cycles, self.frames = design, cycles, frames
        banks = {source.token: source.banks for source in plan.sources if source.token}
        numbers = {**banks, **tokens, **dict.fromkeys(plan.follows, 0)}
        self.tokens = {name: deque([-NEVER] * number) for name, number in numbers.items()}
        self.products = Products(self, plan)
        self.units: list[Unit] = [self.products]
        self._codes = next(source.stacks[0] for source in plan.sources if not source.token)
        self._intake = Intake(design.sensor.taxels, design.quads, cycles["normaliser.latency"])

    def run(self) -> None:
        """Follow the frames until no unit has work."""
        self.enter(0, -NEVER)
        while True:
            decision = min((unit.decide() for unit in self.units), key=lambda each: each.cycle)
            if decision.cycle >= NEVER:
                return
            decision.act()

    def before(self, number: int) -> F | None:
        """The frame before frame ``number``."""
        return self.frames[number - 1] if number else None

    def enter(self, number: int, bank_free: int) -> None:
        """Taxels of frame ``number``, if there is one; the bank of b takes quads from the cycle ``bank_free`` on."""
        if number == len(self.frames):
            return
        before = self.before(number)
        normaliser = self._intake.last_taxel(before.taxel) if before else 0
        self.frames[number].taxel = max(normaliser, self.last_taxel(number))
        self.products.add(self._codes, number, self._intake.last_quad(normaliser, bank_free))

    def last_taxel(self, number: int) -> int:
        """When other blocks than the normaliser have taken the last taxel of frame ``number``."""
        return 0

    @abstractmethod
    def after(self, stack: str, number: int, results: list[int]) -> None:
        """Follow the ``results`` of a product of frame ``number``: the cycles in which its quads reach their users."""

    def result_words(self, first: int, planes: Sequence[int]) -> list[int]:
        """Cycles of result words: header from ``first`` on, each plane when its forces come, status; one a cycle."""
        taxels = self.design.sensor.taxels
        header = self.design.frame_words - 1 - taxels * len(planes)
        words = list(range(first, first + header))
        for plane in planes:
            start = max(plane, words[-1] + 1)
            words += range(start, start + taxels)
        return [*words, words[-1] + 1]


def last_entry(arrivals: Iterable[int], earliest: int, interval: int) -> int:
    """When the last of ``arrivals`` enters a block: each when it is there, ``interval`` after the one before it."""
    entry = earliest - interval
    for arrival in arrivals:
        entry = max(arrival, entry + interval)
    return entry
