"""Cycles of normaliser and fold: taxels of frames back to back, until their quads wait at the first product."""

NEVER = 1 << 62
"""A cycle that does not come; its negative is before all others."""


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
