"""Timeline of the vector updates: e0, e1 and d begin when all their inputs are available and a bank is free."""

from __future__ import annotations

from tfra.hdl.lib.streams import Buffer, PerFrameFifo
from tfra.hdl.parallel.tfra.combine.store import MEASURE
from tfra.hdl.parallel.tfra.timeline.events import NEVER, Events, Span, Vector

_SEEN = 1
"""Cycles until the arbiter sees that a fact is available."""

_NEXT_FRAME = 3
"""Cycles from the last beat of a frame's vectors to the choice of the next frame's: its store's place moves on."""


class Updates:
    """Vectors in the order in which they are begun; d of an older frame goes before e0 and e1."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._begin_from = -NEVER
        self._candidates_from = self._winner_from = -NEVER
        """Cycles from which e0 or e1, or d, of the next frame may begin."""
        self._candidates = self._winners = 0
        """Frames whose e0 and e1, or d, have been made."""
        self._e1_is_next = False

    def choice(self) -> tuple[int, str, int]:
        """Cycle in which the next vector is begun, its name, and the frame."""
        events, ready = self._events, []
        if self._winners < self._candidates and events.frames[self._winners].chosen:
            frame = events.frames[self._winners]
            fact = frame.chosen + PerFrameFifo.latency + _SEEN
            ready.append((max(fact, frame.e1 + MEASURE, self._winner_from), "d", self._winners))
        if self._candidates < events.residuals:
            frame = events.frames[self._candidates]
            facts = max(frame.affine, frame.direction) + Buffer.latency + PerFrameFifo.latency + _SEEN
            seen = max(frame.residual + MEASURE, facts, self._candidates_from)
            ready.append((seen, "e1" if self._e1_is_next else "e0", self._candidates))
        if not ready:
            return NEVER, "", 0
        cycle = max(self._begin_from, min(r[0] for r in ready), events.bank_tokens.seen())
        return next((cycle, name, frame) for seen, name, frame in ready if seen <= cycle)

    def run(self, cycle: int, name: str, number: int) -> None:
        """Beats of a vector enter where none of a product of forces does."""
        events, entry = self._events, cycle
        events.bank_tokens.take()
        entries = []
        for _ in range(events.design.quads * events.design.cycles_per_quad):
            entry += 1
            while entry in events.force_beats:
                entry += 1
            entries.append(entry)
        self._begin_from = entry + 1
        made = entry + events.blocks.combine
        events.vectors.append(Vector(made, name == "d", number))
        events.spans.append(Span("combine", name, number, entries[0], entry + 1))
        if name == "d":
            self._winners += 1
            self._winner_from = entry + _NEXT_FRAME
        else:
            self._e1_is_next = name == "e0"
        if name == "e1":
            self._candidates += 1
            self._candidates_from = entry + _NEXT_FRAME
            events.frames[number].e1 = made - 1
