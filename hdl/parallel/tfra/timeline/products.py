"""Timeline of the matrix-vector unit: it chooses a product among the available operands, and runs its passes."""

from __future__ import annotations

from dataclasses import dataclass

from tfra.hdl.lib.streams import Router
from tfra.hdl.parallel.matvec.passes import Passes
from tfra.hdl.parallel.matvec.unit import FULL, full
from tfra.hdl.parallel.tfra.plan import PLAN
from tfra.hdl.parallel.tfra.timeline.events import NEVER, Events, Span

_BANK_FREE = 2
"""Cycles from the last launch of a contact product to the first quad of the next b: b's bank is freed, then seen."""


@dataclass(frozen=True)
class Product:
    """The product of a frame by ``stack``, whose last pass is launched in ``last_launch``.

    ``results`` are the cycles in which its result quads reach their sinks.
    """

    stack: str
    frame: int
    last_launch: int
    results: list[int]


class Products:
    """Products in the order in which the unit chooses them."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._passes = Passes(events.design)
        self._last_launch = -_BANK_FREE
        self._contacts = self._vectors = 0
        """Contact products so far; vectors that were multiplied."""

    @property
    def bank_free(self) -> int:
        """Cycle from which b's bank takes quads, after the last product."""
        return self._last_launch + _BANK_FREE

    def choice(self) -> tuple[int, str, int]:
        """Cycle of the next choice, the stack, and the frame."""
        events, wanted = self._events, []
        if self._vectors < len(events.vectors):
            vector = events.vectors[self._vectors]
            leave = events.plane_tokens.seen() if vector.is_d else 0
            wanted.append((max(vector.last + FULL, leave), "force" if vector.is_d else "normal", vector.frame))
        if events.residuals < self._contacts:
            number = events.residuals
            wanted.append((events.frames[number].n + FULL, "residual", number))
        if self._contacts < len(events.frames):
            number = self._contacts
            leave = max(events.frame_tokens.seen(), events.weight_tokens.seen())
            seen = events.frames[number].b + full(events.design, PLAN, "contact")
            wanted.append((max(seen, leave), "contact", number))
        if not wanted:
            return NEVER, "", 0
        cycle = max(self._passes.next_choice, min(w[0] for w in wanted))
        return next((cycle, stack, frame) for seen, stack, frame in wanted if seen <= cycle)

    def run(self, cycle: int, stack: str, number: int) -> Product:
        """All passes of a product that is chosen in ``cycle``, and when its results leave."""
        events, design = self._events, self._events.design
        self._take(stack)
        launches, left = self._passes.product(stack, cycle)
        self._last_launch = launches[-1]
        events.spans.append(Span("matvec", stack, number, launches[0] + 1, launches[-1] + 1 + design.quads))
        self._give(stack, launches[-1])
        return Product(stack, number, launches[-1], [quad + Router.latency for quad in left])

    def _take(self, stack: str) -> None:
        """Count the product, and take its tokens."""
        events = self._events
        if stack == "contact":
            self._contacts += 1
            events.frame_tokens.take()
            events.weight_tokens.take()
        elif stack == "residual":
            events.residuals += 1
        else:
            self._vectors += 1
        if stack == "force":
            events.plane_tokens.take()

    def _give(self, stack: str, last_launch: int) -> None:
        """Give the operand's bank back after the last pass over it."""
        if stack == "residual":
            self._events.weight_tokens.give(last_launch + 1)
        elif stack != "contact":
            self._events.bank_tokens.give(last_launch + 1)
