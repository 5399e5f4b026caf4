"""Timeline of the blocks before the products: normaliser, centroids and fold."""

from __future__ import annotations

from tfra.hdl.parallel.tfra.timeline.events import NEVER, Events


class Front:
    """Taxels of frames back to back, until the quads of b wait at the matrix-vector unit."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._last_quad = -NEVER
        """Of the frame before, out of the normaliser."""
        self._fold: list[tuple[int, int]] = []
        """Of every quad: the cycle in which it moves to the fold's second register, and in which it leaves that."""

    def frame(self, number: int, bank_free: int) -> None:
        """Frame ``number``, if there is one; b's bank takes quads from the cycle ``bank_free`` on."""
        if number == len(self._events.frames):
            return
        events, taxels, wait = self._events, self._events.design.sensor.taxels, self._events.blocks
        frame, before = events.frames[number], events.before(number)
        normaliser = centroids = 0
        if before:
            # Both take the last taxel when the frame before has left them, each at its own time.
            normaliser = max(before.taxel + taxels, self._last_quad + 1)
            centroids = max(before.taxel + taxels, before.direction + 1)
        frame.taxel = max(normaliser, centroids)
        frame.direction = centroids + wait.centroids
        entered = normaliser + wait.normaliser - 1
        for _ in range(events.design.quads):
            entered = self._enter_fold(entered + 1, bank_free)
        self._last_quad, frame.b = entered, self._fold[-1][1]

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
