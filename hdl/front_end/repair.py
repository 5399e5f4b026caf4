"""The table of repairs, term by term."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.codes import FETCH, Codes, term_slot
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.ram import Ram
from tfra.model.fixed.front_end import WEIGHT, repair_places

_ENTRY = data.StructLayout({"weight": signed(WEIGHT), "taxel": BITS - 1 - WEIGHT, "header": 1})
"""A word of the table: a header names the target of the terms that follow, a term its source and its weight."""


class Repair(wiring.Component):
    """Issue a term a cycle, while no taxel comes to the multiplier.

    ::

        number ─▶ table ─▶ (fetched) ─▶ entry (valid) ─▶ term, source

    A header, or the end of the table, is an end of the sum before it; the next term waits until that one's code is
    written.  For a table of ``n`` words with ``h`` headers, the first word a header, that is :meth:`cycles`.
    """

    def __init__(self, taxels: int) -> None:
        self._places = repair_places(taxels)
        super().__init__({
            "write": In(1),  # software writes ``data`` at ``place``
            "place": In(counter_shape(self._places - 1)),
            "data": In(BITS),
            "stored": Out(BITS),  # the word at ``place`` a cycle before, while no frame is repaired
            "repair_words": In(16),  # setting: how many are used
            "active": In(1),  # a frame is to be repaired ...
            "repaired": Out(1),  # ... until it is
            "blocked": In(1),  # a taxel comes to the multiplier ``FETCH`` cycles later
            "term": Out(term_slot(taxels)),
            "source": Out(counter_shape(taxels - 1)),  # the taxel whose code the term needs
        })

    @staticmethod
    def cycles(words: int, headers: int) -> int:
        """Cycles that repairs take."""
        return words + (FETCH + Codes.latency) * headers + 3 if words else 0

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        table = Ram(m, "table", BITS, self._places)
        table.write(self.write, self.place, self.data)
        number = Signal(16)  # of the next word
        fetched = Signal()  # a word is read
        valid = Signal()  # ``entry`` is a word
        entry = Signal(_ENTRY, reset_less=True)
        opened = Signal()  # a target has been named
        target = Signal.like(self.term.target, reset_less=True)
        pending = Signal(FETCH + Codes.latency)  # bit k: a sum ended k + 1 cycles ago, and its code is not written
        more = self.active & (number < self.repair_words)
        empty = ~(more | fetched | valid)
        end = empty | entry.header
        issue = (valid | (empty & opened)) & ~self.blocked & ~pending.any()
        advance = ~valid | issue
        m.d.comb += [
            self.repaired.eq(empty & ~opened & ~pending.any()),
            self.term.valid.eq(issue),
            self.term.end.eq(end),
            self.term.writes.eq(end & opened),
            self.term.weight.eq(Mux(end, 0, entry.weight)),
            self.term.target.eq(target),
            self.source.eq(entry.taxel),
        ]
        word = table.read(Mux(self.active, number, self.place), advance)
        m.d.comb += self.stored.eq(word)
        m.d.sync += pending.eq(Cat(issue & end & opened, pending))
        with m.If(advance):
            m.d.sync += [
                number.eq(number + more),
                fetched.eq(more),
                valid.eq(fetched),
                entry.eq(word),
            ]
        with m.If(issue & end):
            m.d.sync += opened.eq(valid)
            m.d.sync += target.eq(entry.taxel)
        with m.If(~self.active):
            m.d.sync += number.eq(0)
        return m
