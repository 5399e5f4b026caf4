"""Timeline of the blocks before the products: normaliser, centroids and fold."""

from __future__ import annotations

from tfra.hdl.parallel.intake import Intake
from tfra.hdl.parallel.tfra.timeline.events import Events


class Front:
    """Taxels of frames back to back, until the quads of b wait at the matrix-vector unit."""

    def __init__(self, events: Events) -> None:
        self._events = events
        self._intake = Intake(events.design.sensor.taxels, events.design.quads, events.blocks.normaliser)

    def frame(self, number: int, bank_free: int) -> None:
        """Frame ``number``, if there is one; b's bank takes quads from the cycle ``bank_free`` on."""
        if number == len(self._events.frames):
            return
        events = self._events
        frame, before = events.frames[number], events.before(number)
        normaliser = centroids = 0
        if before:
            # Both take the last taxel when the frame before has left them, each at its own time.
            normaliser = self._intake.last_taxel(before.taxel)
            centroids = max(before.taxel + events.design.sensor.taxels, before.direction + 1)
        frame.taxel = max(normaliser, centroids)
        frame.direction = centroids + events.blocks.centroids
        frame.b = self._intake.last_quad(normaliser, bank_free)
