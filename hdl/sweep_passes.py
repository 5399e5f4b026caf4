"""The sweep's loop: all taxels once per P candidates, with x and y of the first of them."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import delayed, product_latency, registered_product, walk
from tfra.hdl.sweep_lanes import grid_stress, lanes_latency, swept_taxel, swept_words, unit_shift
from tfra.hdl.sweep_loader import PLACES, TAXEL, folded_taxel
from tfra.model.design import Design
from tfra.model.fixed.widths import widths

_AGAIN = 3
"""Cycles from the read of the memory to the lanes: memory, its register, the lanes' input."""


def pass_interval(design: Design) -> int:
    """Cycles between the ends of two passes: the taxels and the end marker.

    With many lanes the loop through lanes and memory is longer, or the read-out of the rows before the next.
    """
    lanes = design.architecture.sweep_lanes
    return max(design.sensor.taxels + 1, lanes + 1 + _AGAIN, lanes + lanes_latency(design))


def frame_wait(design: Design) -> int:
    """Cycles from taking the last quad of q to taking the next frame's first at the earliest: further passes."""
    interval, first = pass_interval(design), PLACES * design.quads
    return (design.sweep_passes - 1) * interval + max(first + 1, interval) - (first - PLACES)


def measured_sum(design: Design) -> int:
    """Bits of K times the sum of all positive stress."""
    return widths(design).magnitude + design.search.steps.bit_length()


class Passes(wiring.Component):
    """Let the taxels run past the lanes, once per P candidates.

    ``x = K (p - [negative] q)`` and ``y = K b - x`` in the first pass, as the taxels come; then, what the last lane
    made of them, from a memory of ``m`` entries.  An end marker follows every pass.

    Candidates up to K fit the words; x and y wrap beyond, where nothing looks at them, and the wrap does not
    spread, since additions are modular.

    Members:
        i: the loader's taxels; ``ends``: it takes a frame's last quad.
        o, back: to the first lane, and from the last.
        measured, exponent: K times the sum of positive stress and the frame's exponent, from its first row on.

    Resources: two constant products by K, three adders.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "i": In(folded_taxel(design)),
                "ends": In(1),
                "o": Out(swept_taxel(design)),
                "back": In(swept_taxel(design)),
                "measured": Out(unsigned(measured_sum(design))),
                "exponent": Out(payloads.frame_facts(design)["exponent"].shape),
            }
        )

    @staticmethod
    def latency(design: Design) -> int:
        """Cycles from taking the last quad of q to its end marker at the first lane."""
        return TAXEL + PLACES + 2 + product_latency(design.search.steps)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        begin = delayed(m, self.ends, self.latency(self._design) - _AGAIN, control=True)
        complete = delayed(m, begin, _AGAIN - 1, control=True)
        ended: Value = complete
        x, b, slope, valid = self._first_pass(m)
        self._measure(m, b, valid, complete)
        words = self.o.words
        m.d.sync += [words.x.eq(x), words.y.eq((b << unit_shift(self._design)) - x), words.q.eq(slope)]
        if self._design.sweep_passes > 1:
            again, valid_again, ended_again = self._further_passes(m, begin)
            with m.If(valid_again):
                m.d.sync += words.eq(again)
            valid, ended = valid | valid_again, ended | ended_again
        m.d.sync += [self.o.valid.eq(valid), self.o.ended.eq(ended)]
        return m

    def _first_pass(self, m: Module) -> tuple[Value, Value, Value, Value]:
        """K (p - [negative] q), K b, q and whether they are a taxel."""
        w, i, steps = widths(self._design), self.i, self._design.search.steps
        start = Signal(signed(w.vector + 1), reset_less=True)
        m.d.sync += start.eq(i.p - Mux(i.negative, i.q, 0))
        wait = product_latency(steps)
        x = registered_product(m, start, steps)
        b = registered_product(m, delayed(m, i.stress, 1), steps)
        return x, b, delayed(m, i.q, 1 + wait), delayed(m, i.valid, 1 + wait, control=True)

    def _measure(self, m: Module, b: Value, valid: Value, complete: Value) -> None:
        """Sum K b where it is positive; the end marker's step hands it over and clears it."""
        total = Signal(measured_sum(self._design))
        with m.If(valid & ~b[-1]):
            m.d.sync += total.eq(total + b[: grid_stress(self._design) - 1])
        exponent = delayed(m, self.i.exponent, 2 + product_latency(self._design.search.steps))
        with m.If(complete):
            m.d.sync += [total.eq(0), self.measured.eq(total), self.exponent.eq(exponent)]

    def _further_passes(self, m: Module, begin: Value) -> tuple[Value, Value, Value]:
        """All entries once per further pass: words, valid and end marker for the lanes' input."""
        last, interval = self._design.sensor.taxels - 1, pass_interval(self._design)
        memory = Memory(shape=swept_words(self._design), depth=last + 1, init=[])
        m.submodules.memory = memory
        write, read = memory.write_port(), memory.read_port()
        into, _ = walk(m, self.back.valid, last + 1, "into")
        m.d.comb += [write.addr.eq(into), write.data.eq(self.back.words), write.en.eq(self.back.valid)]
        slot, left = Signal(range(interval)), Signal(count(self._design.sweep_passes - 1))
        active, ends, reading = left != 0, slot == interval - 1, Signal()
        with m.If(active):
            m.d.sync += slot.eq(Mux(ends, 0, slot + 1))
            with m.If(ends):
                m.d.sync += left.eq(left - 1)
        with m.If(begin):
            m.d.sync += left.eq(self._design.sweep_passes - 1)
        waits = interval - 1 - (last + 1)  # the first taxel at the end of a pass that is longer than its taxels
        m.d.comb += reading.eq(active & ~ends & (slot >= waits if waits else 1))
        m.d.comb += [read.addr.eq(walk(m, reading, last + 1, "out")[0]), read.en.eq(1)]
        wait = _AGAIN - 1
        valid = delayed(m, reading, wait, control=True)
        return delayed(m, read.data.as_value(), wait - 1), valid, delayed(m, active & ends, wait, control=True)
