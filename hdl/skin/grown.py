"""The taxels about a region that belong to no other contact; see :mod:`tfra.model.skin.regions`."""

from typing import Any

from amaranth import Module, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import READ, delayed, register
from tfra.hdl.skin.payloads import GAP, bitmap, row
from tfra.model.skin.skin import Skin

_WRITTEN = READ + 1
"""Cycles from a row's number to its new word."""


class Grown(wiring.Component):
    """In: a region's bitmap, its first and last row, and the gap.  Out: the region and what is near it, taken.

    =====  ============================================================================================
    READ   reads a row of the region
    TAKE   takes its word, and clears the row for the next region
    WIDEN  spreads the word by a taxel to both sides in each cycle, ``gap`` times
    MERGE  marks the word in the rows from ``gap`` above to ``gap`` below, one a cycle; then the next row
    =====  ============================================================================================

    ``4 + gap + 2 gap + 1`` cycles a row of the region.
    """

    def __init__(self, skin: Skin) -> None:
        self._row, self._rows, self._columns = row(skin), skin.sensor.rows, skin.sensor.columns
        super().__init__({
            "start": In(1),  # pulse
            "first": In(self._row),
            "last": In(self._row),
            "gap": In(GAP),
            "done": Out(1),  # pulse: all is marked
            "region": Out(bitmap(skin)),
            "taken": Out(bitmap(skin)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row = Signal(self._row, reset_less=True)
        spread = Signal(self._columns, reset_less=True)
        left = Signal(self.gap.shape(), reset_less=True)  # taxels to be spread by
        offset = Signal(signed(len(self.gap) + 1), reset_less=True)  # of the row to be marked
        merge = Signal()
        ends = Signal()
        m.d.comb += self.region.row.eq(row)
        m.d.comb += self.region.target.eq(row)
        with m.FSM():
            with m.State("IDLE"):
                m.d.sync += row.eq(self.first)
                with m.If(self.start):
                    m.next = "READ"
            with m.State("READ"):
                m.next = "TAKE"
            with m.State("TAKE"):
                m.d.comb += self.region.write.eq(1)
                m.d.sync += [
                    spread.eq(self.region.word),
                    left.eq(self.gap),
                    offset.eq(-self.gap),
                ]
                m.next = "WIDEN"
            with m.State("WIDEN"):
                m.d.sync += left.eq(left - 1)
                with m.If(left == 0):
                    m.next = "MERGE"
                with m.Else():
                    m.d.sync += spread.eq(spread | (spread << 1) | (spread >> 1))
            with m.State("MERGE"):
                m.d.comb += merge.eq(1)
                m.d.sync += offset.eq(offset + 1)
                with m.If(offset == self.gap):
                    m.d.comb += ends.eq(row == self.last)
                    m.d.sync += row.eq(row + 1)
                    m.next = "READ"
                with m.If(ends):
                    m.next = "IDLE"
        m.d.comb += self.done.eq(delayed(m, ends, _WRITTEN + 1, "done", control=True))
        self._merge(m, merge, row + offset, spread)
        return m

    def _merge(self, m: Module, merge: Value, target: Value, spread: Value) -> None:
        """Mark the ``spread`` word in the row ``target``, if there is one."""
        inside = (target >= 0) & (target < self._rows)
        at = register(m, target[: len(self.taken.row)], "at")
        # ``spread`` is used before the next row's word can take its place.
        word = register(m, self.taken.word | spread, "word")
        m.d.comb += [
            self.taken.row.eq(at),
            self.taken.write.eq(delayed(m, merge & inside, _WRITTEN, "write", control=True)),
            self.taken.target.eq(delayed(m, at, _WRITTEN - 1, "target")),
            self.taken.data.eq(word),
        ]
