"""The peaks of a frame that may be contacts: a list that gets shorter with every search."""

from typing import Any

from amaranth import Module, Mux, Signal, Value, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import READ, busy_after, delayed, driver, register, serial_product
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import Buffer, always_ready_stream
from tfra.hdl.skin.payloads import PAGES, THRESHOLD, bitmap, height, most_peaks, peak
from tfra.model.skin.finding import THRESHOLD_FRACTION
from tfra.model.skin.skin import Skin

_DECIDED = 2 * READ + 1
"""Cycles from an index to the decision about its peak: the list, the bitmap, and the decision."""


class Candidates(wiring.Component):
    """In: peaks of frames.  Out, for each search of a frame: the highest that is free and high enough, and how many.

    A list for each page, of which one is filled while the other is searched.  A search reads a peak a cycle and keeps
    those that are free and high enough, in their order, so the next one is shorter::

        list ─▶ register ─▶ bitmap ─▶ register ─▶ decision ─┬▶ list
                                                            └▶ the highest
    """

    def __init__(self, skin: Skin) -> None:
        self._peak, self._height, self._depth = peak(skin), height(skin), most_peaks(skin)
        self._count = counter_shape(self._depth)
        super().__init__({
            "i": In(always_ready_stream(self._peak)),
            "ends": In(1),  # pulse, with the last peak or later: the frame is complete ...
            "highest": In(self._height),  # ... and this is its largest height
            "threshold": In(THRESHOLD),
            "waiting": Out(1),  # a frame is complete
            "begin": In(1),  # pulse: turn to it
            "settled": Out(1),  # a search may start
            "search": In(1),  # pulse
            "searched": Out(1),  # pulse: the next ones are known
            "left": Out(self._count),  # peaks that are free and high enough
            "best": Out(self._peak),  # the highest of them; of equal ones the first
            "taken": Out(bitmap(skin)),  # taxels that are not free
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        facts = data.StructLayout({"count": self._count, "highest": self._height})
        m.submodules.facts = waiting = Buffer(facts)
        page_in = Signal(range(PAGES))
        page_out = Signal(range(PAGES), init=PAGES - 1)  # turns when a frame begins
        number = Signal(self._count)  # peaks of the frame that comes
        m.d.comb += [
            waiting.i.valid.eq(self.ends),
            waiting.i.payload.count.eq(number + self.i.valid),
            waiting.i.payload.highest.eq(self.highest),
            self.waiting.eq(waiting.o.valid),
            waiting.o.ready.eq(self.begin),
        ]
        with m.If(self.ends):
            m.d.sync += number.eq(0)
            m.d.sync += page_in.eq(~page_in)
        with m.Elif(self.i.valid):
            m.d.sync += number.eq(number + 1)
        with m.If(self.begin):
            m.d.sync += page_out.eq(~page_out)
        self._search(m, waiting.o.payload, page_in, page_out, number)
        return m

    def _search(self, m: Module, facts: Any, page_in: Value, page_out: Value, number: Value) -> None:
        """Read the list to its end and write it again."""
        left, best = driver(m, self.left), driver(m, self.best)
        put = Signal(self._count, reset_less=True)
        reading = Signal()
        index = Signal(counter_shape(self._depth - 1), reset_less=True)
        last = index == left - 1
        limit = self._limit(m, facts.highest)
        keep = Signal()
        kept = Signal(self._peak)
        stored = self._lists(m, (page_in, number), (page_out, index), (keep, put, kept))
        m.d.comb += self._decide(m, stored, limit, reading, keep, kept)
        empty = self.search & (left == 0)
        complete = delayed(m, (reading & last) | empty, _DECIDED + 1, "complete", control=True)
        m.d.comb += self.searched.eq(register(m, complete, "searched", control=True))
        with m.If(self.begin):
            m.d.sync += left.eq(facts.count)
        with m.Elif(complete):
            m.d.sync += left.eq(put)
        with m.If(self.search):
            m.d.sync += [
                reading.eq(~empty),
                index.eq(0),
                put.eq(0),
                best.height.eq(0),
            ]
        with m.Elif(reading):
            m.d.sync += reading.eq(~last)
            m.d.sync += index.eq(index + 1)
        with m.If(keep):
            m.d.sync += put.eq(put + 1)
            with m.If(kept.height > best.height):
                m.d.sync += best.eq(kept)

    def _limit(self, m: Module, highest: Value) -> Value:
        """The frame's highest times the threshold, bit by bit, since a frame has one."""
        digits = self.threshold.shape().width
        word = Signal(self._height, reset_less=True)
        with m.If(self.begin):
            m.d.sync += word.eq(highest)
        busy = busy_after(m, self.begin, digits)
        m.d.comb += self.settled.eq(~busy)
        return serial_product(m, word, self.threshold, digits, self.begin, busy, "limit")

    def _decide(self, m: Module, stored: Any, limit: Value, reading: Value, keep: Value, kept: Any) -> list[Any]:
        """Whether a peak that is ``stored`` stays."""
        read = Signal(self._peak, reset_less=True)
        m.d.sync += read.eq(stored)
        high = register(m, (read.height << THRESHOLD_FRACTION) >= limit, "high")
        row = register(m, self.taken.word, "row")
        later = delayed(m, read, READ, "later")
        free = ~row.bit_select(later.place.column, 1)
        valid = delayed(m, reading, 2 * READ, "valid", control=True)
        return [
            self.taken.row.eq(read.place.row),
            keep.eq(register(m, valid & free & register(m, high, "high"), "keep", control=True)),
            kept.eq(register(m, later, "kept")),
        ]

    def _lists(self, m: Module, comes: Any, reads: Any, keeps: Any) -> Any:
        """The lists of both pages: peaks that come, reads, and peaks that stay; the word read, a cycle later."""
        page_in, number = comes
        page_out, index = reads
        keep, put, kept = keeps
        words = []
        for page in range(PAGES):
            memory = Ram(m, f"list{page}", unsigned(self._peak.size), self._depth)
            stays = keep & (page_out == page)
            enters = self.i.valid & (page_in == page)
            memory.write(
                stays | enters, Mux(stays, put, number), Mux(stays, kept.as_value(), self.i.payload.as_value())
            )
            words.append(memory.read(index))
        return Mux(page_out[0], words[1], words[0])
