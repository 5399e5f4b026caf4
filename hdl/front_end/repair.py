"""The table of repairs, term by term."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.codes import FETCH, Codes, term_slot
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.model.fixed.front_end import WEIGHT, repair_places

_ENTRY = data.StructLayout({"weight": signed(WEIGHT), "taxel": BITS - 1 - WEIGHT, "header": 1})


class Repair(wiring.Component):
    """Gives out a term a cycle, while no taxel comes to the multiplier.

    A header, or the end of the table, is an end of the sum before it; the next term waits until that one's code is
    written.  For a table of ``n`` words with ``h`` headers, the first word a header, that is :meth:`cycles`.

    Members:
        write, place, data: in, of software.
        repair_words: setting, how many are used.
        active: in, a frame is to be repaired, until it is ``repaired``.
        blocked: in, a taxel comes to the multiplier ``FETCH`` cycles later.
        term: out; ``source``: out, the taxel whose code it needs.
    """

    def __init__(self, taxels: int) -> None:
        self._places = repair_places(taxels)
        super().__init__(
            {
                "write": In(1),
                "place": In(counter_shape(self._places - 1)),
                "data": In(BITS),
                "repair_words": In(16),
                "active": In(1),
                "repaired": Out(1),
                "blocked": In(1),
                "term": Out(term_slot(taxels)),
                "source": Out(counter_shape(taxels - 1)),
            }
        )

    @staticmethod
    def cycles(words: int, headers: int) -> int:
        """Cycles that repairs take."""
        return words + (FETCH + Codes.latency) * headers + 3 if words else 0

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.table = table = Memory(shape=BITS, depth=self._places, init=[])
        read, write = table.read_port(), table.write_port()
        number = Signal(16)
        entry = Signal(_ENTRY, reset_less=True)
        found, valid, opened = Signal(), Signal(), Signal()  # a word is read, is the entry; a target has been named
        written = Signal(FETCH + Codes.latency)  # bit k: a sum ended k + 1 cycles ago
        target = Signal.like(self.term.target, reset_less=True)
        more, empty, end, issue, advance = (Signal(name=n) for n in ("more", "empty", "end", "issue", "advance"))
        m.d.comb += [
            *(write.addr.eq(self.place), write.data.eq(self.data), write.en.eq(self.write)),
            *(read.addr.eq(number), read.en.eq(advance)),
            more.eq(self.active & (number != self.repair_words)),
            empty.eq(~(more | found | valid)),
            end.eq(empty | entry.header),
            issue.eq((valid | (empty & opened)) & ~self.blocked & ~written.any()),
            advance.eq(~valid | issue),
            self.repaired.eq(empty & ~opened & ~written.any()),
            *(self.term.valid.eq(issue), self.term.end.eq(end), self.term.writes.eq(end & opened)),
            *(self.term.weight.eq(Mux(end, 0, entry.weight)), self.term.target.eq(target)),
            self.source.eq(entry.taxel),
        ]
        m.d.sync += written.eq(Cat(issue & end & opened, written))
        with m.If(advance):
            m.d.sync += [found.eq(more), valid.eq(found), entry.eq(read.data), number.eq(number + more)]
        with m.If(issue & end):
            m.d.sync += [opened.eq(valid), target.eq(entry.taxel)]
        with m.If(~self.active):
            m.d.sync += number.eq(0)
        return m
