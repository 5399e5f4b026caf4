"""The sweep's sums: B^z, or S of B^xy, of every candidate, in their order."""

from __future__ import annotations

from typing import Any

from amaranth import C, Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import delayed, driver, register
from tfra.hdl.sweep_crossing import Crossing, crossing_latency
from tfra.model.design import Design
from tfra.model.fixed.widths import widths

_UPDATE = 4
"""Cycles from a crossing to the memory that holds it: read, its register, sum, write."""
_WALK = 3
"""Cycles from the read of candidate 1 to the sum of candidate 0, which the next one follows: memory, its register,
slope."""


def first_row(design: Design) -> int:
    """Cycles from the end mark, which comes a cycle behind the last term, to the sum of candidate 0."""
    return crossing_latency(design) + _UPDATE - 1 + _WALK


def sums_wait(design: Design) -> int:
    """Cycles from a frame's last term to the next frame's first at the earliest: the sums of all candidates."""
    return first_row(design) + design.search.steps + 2


def slope_bits(design: Design) -> int:
    """Bits of the sum of all |q|."""
    return widths(design).vector - 1 + design.sensor.taxels.bit_length()


class Sums(wiring.Component):
    """``sum(k) = sum over terms of max(0, first + k step)`` for k = 0 ... K, one a cycle; exact.

    A term counts while it is positive, from k = 0 up to its crossing or from there on, so that the sum is convex,
    straight between crossings:

        sum(0)   = sum of first >= 0                       sum(k)   = sum(k-1) + slope(k-1) + excess of crossings at k
        slope(0) = sum of their steps                      slope(k) = slope(k-1) + size of crossings at k

    ::

        first, step -+-> sum(0), slope(0) ---------------------------.
                     '-> Crossing -> place -> memory of K + 1 entries -+-> slope, sum of the next candidate
                                 size, excess -> + -'

    Terms cost a cycle each and candidates another: no sum is made of terms times candidates.  Entries are cleared as
    they are read, all of them and the sums before the first frame, too.  Crossings at one place may come in consecutive
    cycles; sums on their way to the memory are used instead of what is there.

    Members:
        first, step, size, i_valid: a term; ``size = |step|``; ``ended``: the cycle behind a frame's last one.
        sum, valid: a candidate's sum, those of a frame without a gap.
        begins: the cycle ahead of candidate 0.

    Resources: a :class:`Crossing`, seven adders, a memory of K + 1 entries of about 80 bits.
    """

    def __init__(self, design: Design, first_bits: int, sum_bits: int) -> None:
        self._design = design
        super().__init__(
            {
                "first": In(signed(first_bits)),
                "step": In(signed(widths(design).vector)),
                "size": In(unsigned(widths(design).vector)),
                "i_valid": In(1),
                "ended": In(1),
                "sum": Out(unsigned(sum_bits)),
                "valid": Out(1),
                "begins": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        entry = data.StructLayout(dict.fromkeys(("size", "excess"), unsigned(slope_bits(self._design))))
        m.submodules.crossing = crossing = Crossing(self._design, len(self.first))
        m.submodules.memory = memory = Memory(shape=entry, depth=self._design.search.steps + 1, init=[])
        write, read = memory.write_port(), memory.read_port()
        walking, number = self._turn(m)
        m.d.comb += [
            crossing.first.eq(self.first),
            crossing.rises.eq(~self.step[-1]),
            crossing.i_size.eq(self.size),
            crossing.i_valid.eq(self.i_valid),
            read.en.eq(1),
            read.addr.eq(Mux(walking, number, crossing.place)),
        ]
        found = self._update(m, crossing, walking, number, read.data, write)
        self._walk(m, walking, found)
        return m

    def _turn(self, m: Module) -> tuple[Signal, Signal]:
        """Whether candidates are walked through, and which one is read; first of all, to clear the memory."""
        last = self._design.search.steps
        walking, number = Signal(init=1), Signal(count(last), init=1)
        ended = delayed(m, self.ended, first_row(self._design) - _WALK - 1, "ended", control=True)
        with m.If(walking):
            m.d.sync += [walking.eq(number != last), number.eq(Mux(number == last, 1, number + 1))]
        with m.If(ended):
            m.d.sync += walking.eq(1)
        return walking, number

    def _update(self, m: Module, crossing: Any, walking: Value, number: Value, read: Any, write: Any) -> data.View:
        """Add crossings to their entries, and clear those that are walked through; return what a read has found.

        By cycles behind a crossing: 1 read, 2 ``found``, 3 ``sums``, being written, 4 ``written``.
        """
        place, valid, sums = [crossing.place], [crossing.valid], Signal(read.shape(), reset_less=True)
        for stage in range(1, 5):
            at = Mux(walking, number, place[-1]) if stage == 3 else place[-1]
            place.append(register(m, at, f"place{stage}"))
            valid.append(register(m, valid[-1] | (walking if stage == 3 else 0), f"valid{stage}", control=True))
        third = valid[0] & (valid[2] | walking) & (Mux(walking, number, place[2]) == place[0])
        same = {stage: valid[1] & valid[stage] & (place[stage] == place[1]) for stage in (2, 4)}
        same[3] = register(m, third, "same")
        latest, recent = register(m, same[2], "latest"), register(m, same[3] | same[4], "recent")
        written, found = register(m, sums.as_value(), "written"), register(m, read.as_value(), "found")
        kept = register(m, Mux(same[3], sums.as_value(), written), "kept")
        before = data.View(read.shape(), Mux(latest, sums.as_value(), Mux(recent, kept, found)))
        size, excess = delayed(m, crossing.size, 2, "size"), delayed(m, crossing.excess, 2, "excess")
        m.d.sync += [sums.size.eq(before.size + size), sums.excess.eq(before.excess + excess)]
        with m.If(walking):
            m.d.sync += sums.as_value().eq(0)
        m.d.comb += [write.addr.eq(place[3]), write.data.eq(sums), write.en.eq(valid[3])]
        return data.View(read.shape(), found)

    def _walk(self, m: Module, walking: Value, found: data.View) -> None:
        """The sums of terms, then of one candidate after another."""
        before = delayed(m, walking, _WALK - 2, "before", control=True)
        sloping = register(m, before, "sloping", control=True)
        summing = register(m, sloping, "summing", control=True)
        summed = register(m, summing, "summed", control=True)
        slope, total = Signal(signed(len(found.size) + 1), reset_less=True), driver(m, self.sum)
        gain = register(m, slope + found.excess, "gain")
        counts, quiet = self.i_valid & ~self.first[-1], Signal(init=1)
        with m.If(self.ended):
            m.d.sync += quiet.eq(0)
        with m.If(sloping | counts):
            m.d.sync += slope.eq(slope + Mux(sloping, Cat(found.size, C(0, 1)).as_signed(), self.step))
        with m.If(summing | counts):
            m.d.sync += total.eq(total + Mux(summing, gain, self.first))
        # Each cleared when it has been used, by a register of its own: this goes to all bits of a word.
        end = register(m, sloping & ~before, "slope_ends", control=True)
        with m.If(end):
            m.d.sync += slope.eq(0)
        with m.If(register(m, end, "sum_ends", control=True)):
            m.d.sync += total.eq(0)
        m.d.comb += [self.begins.eq(sloping & ~summing & ~quiet), self.valid.eq((summing | summed) & ~quiet)]
