"""Timeline of the core: the events of consecutive frames, cycle by cycle as in the gateware.

Every block takes a fixed number of cycles, independent of the data.  Two units choose among available work: the
matrix-vector unit chooses a product, the vector updates begin a vector.  Decisions are simulated in the order of their
cycles, since no effect of one is visible before the next cycle; all other events follow from their inputs frame by
frame.  A cycle number is that of the clock edge of a transfer, or of the cycle in which a state is visible.  Taxels are
always valid and results always ready.
"""

from __future__ import annotations

from tfra.hdl.parallel.tfra.timeline.back import Back
from tfra.hdl.parallel.tfra.timeline.blocks import BlockCycles
from tfra.hdl.parallel.tfra.timeline.events import NEVER, Events, Frame, Span
from tfra.hdl.parallel.tfra.timeline.front import Front
from tfra.hdl.parallel.tfra.timeline.products import Products
from tfra.hdl.parallel.tfra.timeline.updates import Updates
from tfra.model.fixed.design import Design


class Timeline:
    """The events of ``frames`` frames whose taxels come back to back; the first frame's last taxel comes in cycle 0."""

    def __init__(self, design: Design, blocks: BlockCycles, frames: int) -> None:
        events = Events(design, blocks, frames)
        self.frames: list[Frame] = events.frames
        self.spans: list[Span] = events.spans
        self._front, self._back = Front(events), Back(events)
        self._products, self._updates = Products(events), Updates(events)
        self._front.frame(0, 0)
        while self._step():
            pass

    def _step(self) -> bool:
        """The earlier of the next two decisions; false at the end."""
        product, vector = self._products.choice(), self._updates.choice()
        if min(product[0], vector[0]) >= NEVER:
            return False
        if product[0] <= vector[0]:
            done = self._products.run(*product)
            self._back.after(done)
            if done.stack == "contact":
                self._front.frame(done.frame + 1, self._products.bank_free)
        else:
            self._updates.run(*vector)
        return True
