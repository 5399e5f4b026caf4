"""The sweep's loop: all taxels once per P candidates, with x of the first of them."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import delayed, product_latency, registered_product
from tfra.hdl.sweep_loader import folded_taxel
from tfra.model.design import Design
from tfra.model.fixed.widths import widths


def swept_words(design: Design) -> data.StructLayout:
    """What a pass reads and writes of one taxel; ``b`` is its stress, or minus the sum of all positive ones."""
    w = widths(design)
    return data.StructLayout({"x": signed(w.candidate), "q": signed(w.vector), "b": signed(w.magnitude + 1)})


def swept_taxel(design: Design) -> data.StructLayout:
    """One step of the lanes; ``measured`` marks a pass's last, whose ``b`` enters the sums whatever its sign."""
    return data.StructLayout({"words": swept_words(design), "valid": 1, "measured": 1})


def pass_interval(design: Design) -> int:
    """Cycles between two passes: the taxels, the measured sum and one to clear the lanes.

    The smallest arrays wait a little for ``x + P q``, which must be written before it is read again.
    """
    loop = 4 + product_latency(design.architecture.sweep_lanes)
    return max(design.sensor.taxels + 2, loop)


class Passes(wiring.Component):
    """Let the taxels run past the lanes, once per P candidates, each time with ``x`` of the pass's first one.

    ``x = K (p - [negative] q)`` in the first pass, as the taxels come; ``x + P q`` in the next, from a memory of
    ``m + 1`` entries.  The last entry is the measured sum: with ``x = q = 0`` and ``b`` = minus the sum of positive
    stress it subtracts M from what the lanes sum.

    Candidates up to K fit ``widths.candidate``; x wraps beyond, where nothing looks at it, and the wrap does not
    spread, since additions are modular.

    Resources: a constant product each by K and P, three adders.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "i": In(folded_taxel(design)),
                "negative": In(1),
                "idle": In(1),
                "o": Out(swept_taxel(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first = self._first_pass(m)
        if self._design.sweep_passes == 1:
            m.d.sync += self.o.eq(first)
            return m
        m.submodules.memory = memory = Memory(
            shape=swept_words(self._design), depth=self._design.sensor.taxels + 1, init=[]
        )
        self._write(m, memory)
        words, valid, measured = self._read(m, memory, first.measured)
        m.d.sync += [
            self.o.words.eq(Mux(valid, words.as_value(), first.words.as_value())),
            self.o.valid.eq(first.valid | valid),
            self.o.measured.eq(first.measured | measured),
        ]
        return m

    def _first_pass(self, m: Module) -> data.View:
        design, w, i = self._design, widths(self._design), self.i
        positive = Signal(signed(w.magnitude + 1), reset_less=True)
        start = Signal(signed(w.vector + 1), reset_less=True)
        slope = Signal(signed(w.vector), reset_less=True)
        b = Signal(signed(w.magnitude + 1), reset_less=True)
        with m.If(self.idle):
            m.d.sync += positive.eq(0)
        with m.Elif(i.valid & (i.stress > 0)):
            m.d.sync += positive.eq(positive - i.stress)
        m.d.sync += [start.eq(i.p - Mux(self.negative, i.q, 0)), slope.eq(i.q), b.eq(i.stress)]
        with m.If(i.measured):
            m.d.sync += [start.eq(0), slope.eq(0), b.eq(positive)]
        wait, steps = product_latency(design.search.steps), design.search.steps
        first = Signal(swept_taxel(design))
        m.d.comb += [
            first.words.x.eq(registered_product(m, start, steps)),
            first.words.q.eq(delayed(m, slope, wait)),
            first.words.b.eq(delayed(m, b, wait)),
            first.valid.eq(delayed(m, i.valid | i.measured, 1 + wait, control=True)),
            first.measured.eq(delayed(m, i.measured, 1 + wait, control=True)),
        ]
        return first

    def _write(self, m: Module, memory: Memory) -> None:
        """``x + P q`` of every entry, in order, behind the lanes' input."""
        lanes, last = self._design.architecture.sweep_lanes, self._design.sensor.taxels
        wait = product_latency(lanes)
        write, address = memory.write_port(), Signal(count(last))
        now = data.View(swept_words(self._design), delayed(m, self.o.words.as_value(), wait))
        then = Signal(swept_words(self._design), reset_less=True)
        m.d.sync += [
            then.x.eq(now.x + registered_product(m, self.o.words.q, lanes)),
            then.q.eq(now.q),
            then.b.eq(now.b),
        ]
        valid = delayed(m, self.o.valid, 1 + wait, control=True)
        m.d.comb += [write.addr.eq(address), write.data.eq(then), write.en.eq(valid)]
        with m.If(valid):
            m.d.sync += address.eq(Mux(address == last, 0, address + 1))

    def _read(self, m: Module, memory: Memory, begin: Value) -> tuple[data.View, Value, Value]:
        """All entries once per further pass; the words, and the marks that go with them."""
        last, interval = self._design.sensor.taxels, pass_interval(self._design)
        read, active = memory.read_port(), Signal()
        slot, left = Signal(range(interval)), Signal(count(self._design.sweep_passes - 1))
        with m.If(active):
            m.d.sync += slot.eq(slot + 1)
            with m.If(slot == interval - 1):
                m.d.sync += [slot.eq(0), left.eq(left - 1), active.eq(left != 1)]
        with m.If(delayed(m, begin, interval - (last + 2), control=True)):
            m.d.sync += [active.eq(1), slot.eq(0), left.eq(self._design.sweep_passes - 1)]
        valid, measured = active & (slot <= last), active & (slot == last)
        m.d.comb += [read.addr.eq(slot), read.en.eq(valid)]
        return read.data, delayed(m, valid, 1, control=True), delayed(m, measured, 1, control=True)
