"""The table of repairs, term by term."""

from typing import Any

from amaranth import Module, Mux, Signal, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.codes import FETCH, Codes, term_slot
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.ram import Ram
from tfra.model.fixed.front_end import WEIGHT, repair_places

_ENTRY = data.StructLayout({"weight": signed(WEIGHT), "taxel": BITS - 1 - WEIGHT, "header": 1})
"""A word of the table: a header names the target of the terms that follow, a term its source and its weight."""


class Repair(wiring.Component):
    """Issue a term a cycle, while no taxel comes to the multiplier.

    ::

        number ─▶ table ─▶ (fetched) ─▶ entry (valid) ─▶ (issue) ─▶ term, source

    A header, or the end of the table, is an end of the sum before it; the next term waits until that one's code is
    written.  For a table of ``n`` words with ``h`` headers, the first word a header, that is :meth:`cycles`.
    """

    def __init__(self, taxels: int) -> None:
        self._places = repair_places(taxels)
        super().__init__({
            "write": In(1),  # software writes ``data`` at ``place``
            "place": In(counter_shape(self._places - 1)),
            "data": In(BITS),
            "stored": Out(BITS),  # the word at ``place`` two cycles before, while no frame is repaired
            "repair_words": In(16),  # setting: how many are used
            "active": In(1),  # a frame is to be repaired ...
            "repaired": Out(1),  # ... until it is
            "blocked": In(1),  # a taxel comes to the multiplier ``FETCH + 1`` cycles later
            "term": Out(term_slot(taxels)),  # registers
            "source": Out(counter_shape(taxels - 1)),  # the taxel whose code the term needs
            "settles": In(1),  # the code of the last sum is written a cycle later
        })

    @staticmethod
    def cycles(words: int, headers: int) -> int:
        """Cycles that repairs take."""
        return words + (FETCH + Codes.latency) * headers + 3 if words else 0

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        table = Ram(m, "table", BITS, self._places)
        table.write(self.write, self.place, self.data)
        number = Signal.like(self.place)  # of the next word
        left = Signal(16)  # words from that one on ...
        more = Signal()  # ... and whether there are any
        fetched = Signal()  # a word is read
        valid = Signal()  # ``entry`` is a word
        entry = Signal(_ENTRY, reset_less=True)
        opened = Signal()  # a target has been named
        target = Signal.like(self.term.target, reset_less=True)
        waits = Signal()  # a sum has ended, and its code is not written
        empty = ~(more | fetched | valid)
        end = empty | entry.header
        issue = (valid | (empty & opened)) & ~self.blocked & ~waits
        advance = ~valid | issue
        word = table.read(Mux(self.active, number, self.place), advance)
        m.d.comb += [
            self.stored.eq(entry),
            self.repaired.eq(empty & ~opened & ~waits),
            self.term.valid.eq(register(m, issue, "valid", control=True)),
            self.term.end.eq(register(m, end, "end")),
            self.term.writes.eq(register(m, end & opened, "writes")),
            self.term.weight.eq(register(m, Mux(end, 0, entry.weight), "weight")),
            self.term.target.eq(register(m, target, "target")),
            self.source.eq(register(m, entry.taxel, "source")),
        ]
        m.d.sync += waits.eq((issue & end & opened) | (waits & ~self.settles))
        with m.If(advance):
            m.d.sync += [
                number.eq(number + more),
                left.eq(left - more),
                more.eq(more & (left != 1)),
                fetched.eq(more & self.active),
                valid.eq(fetched),
                entry.eq(word),
            ]
        with m.If(issue & end):
            m.d.sync += opened.eq(valid)
            m.d.sync += target.eq(entry.taxel)
        with m.If(~self.active):
            m.d.sync += [
                number.eq(0),
                left.eq(self.repair_words),
                more.eq(self.repair_words.any()),
            ]
        return m
