"""Timeline of the vector updates: e0, e1 and d begin when all their inputs are available and a bank is free."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from tfra.hdl.lib.streams import Buffer, PerFrameFifo
from tfra.hdl.parallel.core.intake import NEVER
from tfra.hdl.parallel.core.timeline import IDLE, SEEN, Decision
from tfra.hdl.parallel.tfra.combine.store import MEASURE

if TYPE_CHECKING:
    from tfra.hdl.parallel.tfra.timeline import TfraTimeline

_NEXT_FRAME = 3
"""Cycles from the last beat of a frame's vectors to the choice of the next frame's: its store's place moves on."""


class Updates:
    """Vectors in the order in which they are begun; d of an older frame goes before e0 and e1."""

    def __init__(self, timeline: TfraTimeline) -> None:
        self._timeline = timeline
        self.candidates: deque[int] = deque()
        """Frames that wait for e0 and e1."""
        self.winners: deque[int] = deque()
        """Frames that wait for d."""
        self.force_beats: set[int] = set()
        """Cycles in which products of forces enter."""
        self._e1_is_next = False
        # Cycles from which any vector may begin; e0 or e1 of the next frame; its d.
        self._begin_from = self._candidates_from = self._winners_from = -NEVER

    def decide(self) -> Decision:
        """The next vector."""
        frames, ready = self._timeline.frames, []
        if self.winners:
            frame = frames[self.winners[0]]
            fact = frame.chosen + PerFrameFifo.latency + SEEN
            ready.append((max(fact, frame.e1 + MEASURE, self._winners_from), "d"))
        if self.candidates:
            frame = frames[self.candidates[0]]
            facts = max(frame.affine, frame.direction) + Buffer.latency + PerFrameFifo.latency + SEEN
            seen = max(facts, frame.residual + MEASURE, self._candidates_from)
            ready.append((seen, "e1" if self._e1_is_next else "e0"))
        if not ready:
            return IDLE
        bank = self._timeline.tokens["bank_token"].visible
        cycle = max(self._begin_from, min(seen for seen, _ in ready), bank)
        vector = next(name for seen, name in ready if seen <= cycle)
        return Decision(cycle, lambda: self._run(cycle, vector))

    def _run(self, cycle: int, vector: str) -> None:
        """Beats of a vector enter where none of a product of forces does."""
        timeline, entry = self._timeline, cycle
        timeline.tokens["bank_token"].take()
        for _ in range(timeline.design.quads * timeline.design.cycles_per_quad):
            entry += 1
            while entry in self.force_beats:
                entry += 1
        self._begin_from = entry + 1
        last_quad = entry + timeline.cycles["combine.force_latency"]
        waiting = self.winners if vector == "d" else self.candidates
        number = waiting[0]
        timeline.products.add("force" if vector == "d" else "normal", number, last_quad)
        if vector == "e0":
            self._e1_is_next = True
            return
        waiting.popleft()
        if vector == "d":
            self._winners_from = entry + _NEXT_FRAME
        else:
            self._e1_is_next = False
            self._candidates_from = entry + _NEXT_FRAME
            timeline.frames[number].e1 = last_quad - 1
