"""Timeline of the core: the events of consecutive frames, cycle by cycle as in the gateware.

Every block takes a fixed number of cycles, independent of the data.  One unit chooses among available work: the
matrix-vector unit chooses a product.  Its choices are followed in the order of their cycles; all other events follow
from their inputs frame by frame.  A cycle number is that of the clock edge of a transfer, or of the cycle in which a
state is visible.  Taxels are always valid and results always ready.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tfra.hdl.lib.streams import PerFrameFifo
from tfra.hdl.parallel.intake import Intake
from tfra.hdl.parallel.learned.cycles import Cycles
from tfra.hdl.parallel.learned.plan import FRAMES, UNITS, plan
from tfra.hdl.parallel.learned.total import Total
from tfra.hdl.parallel.matvec.passes import Passes
from tfra.hdl.parallel.matvec.unit import full
from tfra.model.fixed.learned.design import LearnedDesign

_NEVER = 1 << 62

_BANK_FREE = 2
"""Cycles from the last launch of a product to the first quad of the next operand, or to the token of its bank: the bank
is freed, then seen."""

_SEEN = 1
"""Cycles from a token that a block gives to the first in which it is seen."""


@dataclass
class Frame:
    """Cycles of one frame's events, in dataflow order."""

    taxel: int = 0
    operands: dict[str, int] = field(default_factory=dict)
    """By source, the last quad of its operand at its buffer."""
    friction: int = 0
    begun: int = 0
    """The first word enters the field."""
    mantissas: list[int] = field(default_factory=list)
    words: list[int] = field(default_factory=list)
    """Every result word."""


class Timeline:
    """The events of ``number`` frames whose taxels come back to back; the first frame's last taxel comes in cycle 0."""

    def __init__(self, design: LearnedDesign, cycles: Cycles, number: int) -> None:
        self._design, self._cycles = design, cycles
        self._plan = plan(design)
        self.frames = [Frame() for _ in range(number)]
        self._begun = dict.fromkeys(design.products, 0)
        """Products so far, by stack."""
        banks = {source.token: source.banks for source in self._plan.sources if source.token}
        at_first = banks | {"frame_token": FRAMES, "scalars_token": 1}
        self._tokens = {name: [-_NEVER] * count for name, count in at_first.items()}
        self._tokens |= {name: [] for name in self._plan.follows}
        """By name, the cycles in which they were seen first; each is taken by one product."""
        self._passes = Passes(design)
        self._intake = Intake(design.sensor.taxels, design.quads, cycles.normaliser)
        self._enter(0, -_NEVER)
        while self._step():
            pass

    def _step(self) -> bool:
        """The next product; false at the end."""
        ready = [(self._seen(source.stacks[0]), source.stacks[0]) for source in self._plan.sources]
        cycle = max(self._passes.next_choice, min(seen for seen, _ in ready))
        if cycle >= _NEVER:
            return False
        self._run(next(stack for seen, stack in ready if seen <= cycle), cycle)
        return True

    def _seen(self, stack: str) -> int:
        """First cycle in which the next product of ``stack`` may be chosen, as far as known."""
        number = self._begun[stack]
        source = self._plan.source(stack).name
        if number == len(self.frames) or source not in self.frames[number].operands:
            return _NEVER
        tokens = [self._tokens[name] for name in self._plan.needs.get(stack, ())]
        if any(number >= len(times) for times in tokens):
            return _NEVER
        there = self.frames[number].operands[source] + full(self._design, self._plan, stack)
        return max(there, *(times[number] for times in tokens)) if tokens else there

    def _run(self, stack: str, cycle: int) -> None:
        """All passes of a product that is chosen in ``cycle``, and what follows from them."""
        number = self._begun[stack]
        self._begun[stack] += 1
        launches, results = self._passes.product(stack, cycle)
        token = self._plan.source(stack).token
        if token:
            self._tokens[token].append(launches[-1] + _BANK_FREE)
        for name, before in self._plan.follows.items():
            if before == stack:
                self._tokens[name].append(launches[0] + _BANK_FREE)
        if stack == "first":
            self._enter(number + 1, launches[-1] + _BANK_FREE)
        getattr(self, f"_{stack}")(number, results)

    def _enter(self, number: int, bank_free: int) -> None:
        """Taxels of frame ``number``, if there is one, and its folded quads at b's bank."""
        if number == len(self.frames):
            return
        frame = self.frames[number]
        frame.taxel = self._intake.last_taxel(self.frames[number - 1].taxel) if number else 0
        frame.operands["b"] = self._intake.last_quad(frame.taxel, bank_free)

    def _units(self, number: int, stack: str, results: list[int]) -> None:
        """Units at the buffers of the next products."""
        last = -1
        for op in self._design.stacks[stack].operators:
            last += op.quads
            if op.name in UNITS:
                self.frames[number].operands[UNITS[op.name]] = results[last] + self._cycles.activation

    def _first(self, number: int, results: list[int]) -> None:
        self._units(number, "first", results)

    def _second(self, number: int, results: list[int]) -> None:
        self._units(number, "second", results)

    def _read(self, number: int, results: list[int]) -> None:
        """Outputs, and the scalars of the header."""
        cycles, frame = self._cycles, self.frames[number]
        frame.friction = results[0] + Total.latency + cycles.resultant + cycles.friction
        self._tokens["scalars_token"].append(frame.friction + _SEEN)
        if not self._design.taxel_forces:
            self._words(number)

    def _field(self, number: int, results: list[int]) -> None:
        """The field begins after the one before, and so do the mantissas."""
        cycles, frame = self._cycles, self.frames[number]
        frame.begun = max(results[-1] + cycles.vectors, frame.friction + PerFrameFifo.latency)
        if number:
            before = self.frames[number - 1]
            frame.begun = max(frame.begun, before.begun + cycles.field_interval, before.mantissas[-1])
        first = frame.begun + cycles.field + cycles.share
        frame.mantissas = [first + axis * cycles.share_interval for axis in range(3)]
        self._words(number)

    def _words(self, number: int) -> None:
        """Result words: the header when it is complete, each plane after its mantissa, never two in a cycle."""
        frame, cycles, design = self.frames[number], self._cycles, self._design
        header = frame.friction + PerFrameFifo.latency + cycles.words
        before = self.frames[number - 1].words[-1] if number else -_NEVER
        count = design.frame_words - 1 - design.sensor.taxels * len(frame.mantissas)
        begin = max(header, before + 1)
        frame.words = list(range(begin, begin + count))
        for mantissa in frame.mantissas:
            begin = max(mantissa + PerFrameFifo.latency + cycles.forces + cycles.words, frame.words[-1] + 1)
            frame.words += range(begin, begin + design.sensor.taxels)
        frame.words.append(frame.words[-1] + 1)
        self._tokens["frame_token"].append(frame.words[-1] + _SEEN)
