"""The region of a contact, taxel by taxel; see :mod:`tfra.model.skin.regions`."""

from typing import Any, NamedTuple

from amaranth import Array, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import READ, delayed, driver, register
from tfra.hdl.lib.ram import Ram
from tfra.hdl.skin.payloads import bitmap, height, peak, place, region
from tfra.model.skin.skin import Skin

_NEIGHBOURS = 4
_STEPS = 6
"""Cycles from a taxel to the next one, but one: the next one's bitmaps are read when those of this one are written."""
_DECIDED = READ + 2
"""Cycles from a neighbour's place to the decision about it: two memories, their registers, the comparison."""


class _Neighbour(NamedTuple):
    """What is known of a neighbour when it is decided upon; registers, but for ``valid`` of data."""

    valid: Value
    at: Any
    """With ``inside``, for its row and its column, and ``right``: its row has just been written."""
    row: Value
    """The region's taxels in its row."""
    mask: Value
    """The bit of its column."""
    high: Value
    taken: Value
    seen: Value


class Regions(wiring.Component):
    """In: a peak.  Out: its region, the taxels that are at least half as high, free, and connected to it.

    Taxels of the region wait in a queue; the four neighbours of each are looked at, and those that are high, free and
    not yet in the region join its end.  The region is marked in a bitmap, which must be empty at first::

        queue ─▶ taxel ─▶ place of a neighbour ─┬▶ height ─▶ 2 height >= peak ─┬▶ decision ─▶ queue, bitmap, extent
           ▲                                    └▶ bitmaps ─▶ its bit ─────────┘     │
           └─────────────────────────────────────────────────────────────────────────┘

    Seven cycles a taxel, nine if it has only just joined.  The left and the right neighbour share a row, which is read
    for both before either is written: the right one takes the row as the left one has written it.
    """

    def __init__(self, skin: Skin) -> None:
        self._place, self._region = place(skin), region(skin)
        self._rows, self._columns = skin.sensor.rows, skin.sensor.columns
        flags = {"row_inside": 1, "column_inside": 1, "right": 1}
        self._at = data.StructLayout({"place": self._place, **flags})
        super().__init__({
            "start": In(1),  # pulse
            "peak": In(peak(skin)),
            "done": Out(1),  # pulse: the region is complete
            "o": Out(self._region),  # held until the next start
            "place": Out(self._place),  # of a height ...
            "height": In(height(skin)),  # ... a cycle later
            "region": Out(bitmap(skin)),
            "taken": Out(bitmap(skin)),  # taxels that are not free
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        found = driver(m, self.o)
        queue = Ram(m, "queue", self._place, self._rows * self._columns)
        head = Signal(counter_shape(self._rows * self._columns))
        step = Signal(_STEPS)  # of the neighbours of a taxel, one-hot
        busy = Signal()
        fetch = busy & ~step.any()
        taxel = Signal(self._place, reset_less=True)
        waits = head != found.taxels
        at, valid = self._neighbour(m, taxel, step)
        decided = self._look(m, at, valid)
        joins = self._decide(m, decided, found)
        queue.write(joins, found.taxels, decided.at.place)
        following = queue.read(head)
        known = fetch & register(
            m, waits & ~self.start, "known", control=True
        )  # ``following`` is the taxel at the head
        m.d.comb += self.done.eq(fetch & ~known & ~waits & ~self._any(m, valid))
        m.d.sync += step.eq(Cat(known, step))
        with m.If(self.start):
            m.d.sync += busy.eq(1)
            m.d.sync += head.eq(0)
        with m.Elif(self.done):
            m.d.sync += busy.eq(0)
        with m.If(known):
            m.d.sync += head.eq(head + 1)
            m.d.sync += taxel.eq(following)
        return m

    @staticmethod
    def _any(m: Module, valid: Value) -> Value:
        """Whether a neighbour is on its way to the decision."""
        way = Signal(_DECIDED)
        m.d.sync += way.eq(Cat(valid, way))
        return valid | way.any()

    def _neighbour(self, m: Module, taxel: Any, step: Value) -> tuple[Any, Value]:
        """The place of one neighbour after the other, or at the start the peak, which joins as any neighbour does."""
        at = Signal(self._at, reset_less=True)
        valid = register(m, self.start | step[:_NEIGHBOURS].any(), "valid", control=True)
        up, left, right, down = step[:_NEIGHBOURS]
        m.d.sync += [
            at.place.row.eq(Mux(up, taxel.row - 1, Mux(down, taxel.row + 1, taxel.row))),
            at.place.column.eq(Mux(left, taxel.column - 1, Mux(right, taxel.column + 1, taxel.column))),
            at.row_inside.eq(~(up & (taxel.row == 0)) & ~(down & (taxel.row == self._rows - 1))),
            at.column_inside.eq(~(left & (taxel.column == 0)) & ~(right & (taxel.column == self._columns - 1))),
            at.right.eq(right),
        ]
        with m.If(self.start):
            m.d.sync += [
                at.place.eq(self.peak.place),
                at.row_inside.eq(1),
                at.column_inside.eq(1),
            ]
        return at, valid

    def _look(self, m: Module, at: Any, valid: Value) -> _Neighbour:
        """What the memories have about a neighbour."""
        m.d.comb += [
            self.place.eq(at.place),
            self.region.row.eq(at.place.row),
            self.taken.row.eq(at.place.row),
        ]
        read = register(m, at, "read")
        mask = Signal(self._columns, reset_less=True)
        m.d.sync += mask.eq(Array(1 << column for column in range(self._columns))[read.place.column])
        height, row, taken = (
            register(m, word, name)
            for name, word in (("height", self.height), ("row", self.region.word), ("taken", self.taken.word))
        )
        return _Neighbour(
            delayed(m, valid, _DECIDED - 1, "valid", control=True),
            delayed(m, read, 2, "at"),
            register(m, row, "row"),
            register(m, mask, "mask"),
            register(m, (height << 1) >= self.peak.height, "high"),
            register(m, (taken & mask).any(), "taken"),
            register(m, (row & mask).any(), "seen"),
        )

    def _decide(self, m: Module, decided: _Neighbour, found: Any) -> Value:
        """Whether the neighbour joins the region; it is marked, and the extent follows."""
        at = decided.at
        inside = decided.valid & at.row_inside & at.column_inside & decided.high
        joins = inside & ~decided.taken & ~decided.seen
        written = Signal(self._columns, reset_less=True)
        row = Mux(at.right, written, decided.row) | (decided.mask & joins.replicate(self._columns))
        m.d.sync += written.eq(row)
        m.d.comb += [
            self.region.write.eq(decided.valid & at.row_inside),
            self.region.target.eq(at.place.row),
            self.region.data.eq(row),
        ]
        with m.If(self.start):
            m.d.sync += found.taxels.eq(0)
            m.d.sync += found.touching.eq(0)
        with m.Elif(joins):
            m.d.sync += found.taxels.eq(found.taxels + 1)
        with m.Elif(inside & decided.taken):
            m.d.sync += found.touching.eq(1)
        self._extend(m, joins, found.rows, at.place.row)
        self._extend(m, joins, found.columns, at.place.column)
        return joins

    def _extend(self, m: Module, joins: Value, span: Any, index: Value) -> None:
        """The extent along an axis with one more taxel."""
        with m.If(self.start):
            m.d.sync += [
                span.first.eq(-1),
                span.last.eq(0),
                span.total.eq(0),
            ]
        with m.Elif(joins):
            m.d.sync += span.total.eq(span.total + index)
            with m.If(index < span.first):
                m.d.sync += span.first.eq(index)
            with m.If(index > span.last):
                m.d.sync += span.last.eq(index)
