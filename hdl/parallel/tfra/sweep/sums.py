"""The sweep's sums: B^z, or S of B^xy, of every candidate, in their order, one or two a cycle."""

from __future__ import annotations

from typing import Any

from amaranth import C, Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.parallel.tfra.sweep.crossing import Crossing, crossing_latency
from tfra.model.fixed.design import Design

_UPDATE = 5
"""Cycles from a crossing to the memory that holds it: read, its register, choice, sum, write."""
_WALK = 3
"""Cycles from the first read to the sum of candidate 0: memory, its register, slope."""
_PAIR = 2
"""Cycles more where entries are taken in pairs: to add up what both of a pair do to the slope, and to the sum."""


def at_once(design: Design) -> int:
    """Candidates whose sums come in a cycle: two in a core that handles all words of a quad in one."""
    return 2 if design.cycles_per_quad == 1 else 1


def rows(design: Design) -> int:
    """Cycles in which the sums of all candidates come."""
    return design.search.steps // at_once(design) + 1


def _reads(design: Design) -> int:
    """Entries of a bank: candidates 1 ... K take turns among the banks."""
    return -(-design.search.steps // at_once(design))


def _first_sum(design: Design) -> int:
    """Cycles from the end mark, which comes a cycle behind the last term, to the sum of candidate 0 in its register."""
    return crossing_latency(design) + _UPDATE - 1 + _WALK + _PAIR * (at_once(design) - 1)


def first_row(design: Design) -> int:
    """Cycles from the end mark to the first row; a pair of sums has a register more."""
    return _first_sum(design) + at_once(design) - 1


def sums_wait(design: Design) -> int:
    """Cycles from a frame's last term to the next frame's first at the earliest: the sums of all candidates."""
    return _first_sum(design) + _reads(design) + 2


def slope_bits(design: Design) -> int:
    """Bits of the sum of all |q|."""
    return design.widths.vector - 1 + design.sensor.taxels.bit_length()


class Sums(wiring.Component):
    """``sum(k) = sum over terms of max(0, first + k step)`` for k = 0 ... K; exact.

    A term counts while it is positive, from k = 0 up to its crossing or from there on, so that the sum is convex,
    straight between crossings:

        sum(0)   = sum of first >= 0                       sum(k)   = sum(k-1) + slope(k-1) + excess of crossings at k
        slope(0) = sum of their steps                      slope(k) = slope(k-1) + size of crossings at k

    ::

        first, step -+-> sum(0), slope(0) ---------------------------.
                     '-> Crossing -> place -> memory of K entries ----+-> slope, sum of the next candidate
                                 size, excess -> + -'

    Terms cost a cycle each and candidates another, or half of it: no sum is made of terms times candidates.  For two
    candidates a cycle, odd and even entries have a bank each, and a pair of entries moves slope and sum at once:

        slope(k+2) = slope(k) + (size(k+1) + size(k+2))
        sum(k+2)   = sum(k) + 2 slope(k) + (excess(k+1) + size(k+1) + excess(k+2))

    Entries are cleared as they are read, all of them and the sums before the first frame, too, and no crossing comes
    before that is done.  Crossings at one place may come in consecutive cycles; sums on their way to the memory are
    used instead of what is there.

    Members:
        first, step, size, i_valid: a term; ``size = |step|``; ``ended``: the cycle behind a frame's last one.
        sums, valid: the sums of the next ``at_once`` candidates, those of a frame without a gap, and which of them are
            there: behind the last candidate there is none.
        begins: a cycle ahead of candidate 0, or two.

    Resources: a :class:`Crossing`, seven adders, a memory of K entries of about 80 bits; for two candidates a cycle
    seven more adders.
    """

    def __init__(self, design: Design, first_bits: int, sum_bits: int) -> None:
        self._design = design
        super().__init__(
            {
                "first": In(signed(first_bits)),
                "step": In(signed(design.widths.vector)),
                "size": In(unsigned(design.widths.vector)),
                "i_valid": In(1),
                "ended": In(1),
                "sums": Out(unsigned(sum_bits)).array(at_once(design)),
                "valid": Out(at_once(design)),
                "begins": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crossing = crossing = Crossing(self._design, len(self.first))
        walking, number = self._turn(m)
        m.d.comb += [
            crossing.first.eq(self.first),
            crossing.rises.eq(~self.step[-1]),
            crossing.i_size.eq(self.size),
            crossing.i_valid.eq(self.i_valid),
        ]
        self._walk(m, walking, self._update(m, crossing, walking, number))
        return m

    def _turn(self, m: Module) -> tuple[Signal, Signal]:
        """Whether entries are walked through, and which ones are read; first of all, to clear the memory."""
        last = _reads(self._design) - 1
        walking, number = Signal(init=1), Signal(counter_shape(last))
        ended = delayed(m, self.ended, crossing_latency(self._design) + _UPDATE - 2, "ended", control=True)
        with m.If(walking):
            m.d.sync += [walking.eq(number != last), number.eq(Mux(number == last, 0, number + 1))]
        with m.If(ended):
            m.d.sync += walking.eq(1)
        return walking, number

    def _update(self, m: Module, crossing: Any, walking: Value, number: Value) -> list[data.View]:
        """Add crossings to their entries, and clear those that are walked through; return what each bank has found.

        By cycles behind a crossing: 1 read, 2 ``found``, 3 ``stored``, 4 ``sums``, being written, 5 ``written``.
        """
        entry = data.StructLayout(dict.fromkeys(("size", "excess"), unsigned(slope_bits(self._design))))
        ways, depth = at_once(self._design), max(2, _reads(self._design))  # ports need addresses
        inside = ways - 1  # bits of a place that tell the bank
        sums = Signal(entry, reset_less=True)
        place, valid = [crossing.before], [crossing.valid]
        for stage in range(1, 5):
            place.append(register(m, place[-1], f"place{stage}"))
            valid.append(register(m, valid[-1], f"valid{stage}", control=True))
        clear, cleared = register(m, walking, "clear", control=True), register(m, number, "cleared")
        found = []
        for bank in range(ways):
            m.submodules[f"memory{bank}"] = memory = Memory(shape=entry, depth=depth, init=[])
            write, read = memory.write_port(), memory.read_port()
            mine = valid[4] & (place[4][0] == bank) if inside else valid[4]
            m.d.comb += [
                read.addr.eq(Mux(walking, number, place[0] >> inside)),
                write.en.eq(clear | mine),
                write.addr.eq(Mux(clear, cleared, place[4] >> inside)),
                write.data.eq(sums),
            ]
            found.append(register(m, read.data.as_value(), f"found{bank}"))
        # Crossings of the same place, one to four cycles ahead: what they leave is used instead of what was found.
        same = [register(m, valid[0] & valid[ago] & (place[ago] == place[0]), f"same{ago}") for ago in range(1, 5)]
        one, two, three, four = (delayed(m, ago, delay) for ago, delay in zip(same, (2, 1, 0, 0), strict=True))
        latest, written = sums.as_value(), register(m, sums.as_value(), "written")
        kept, recent = register(m, Mux(three, latest, written), "kept"), register(m, three | four, "recent")
        found_there = Mux(place[2][0], found[1], found[0]) if inside else found[0]
        stored = register(m, Mux(two, latest, Mux(recent, kept, found_there)), "stored")
        before = data.View(entry, Mux(one, latest, stored))
        size, excess = delayed(m, crossing.size, 3, "size"), delayed(m, crossing.excess, 3, "excess")
        m.d.sync += [sums.size.eq(before.size + size), sums.excess.eq(before.excess + excess)]
        with m.If(walking):
            m.d.sync += sums.as_value().eq(0)
        return [data.View(entry, word) for word in found]

    def _walk(self, m: Module, walking: Value, found: list[data.View]) -> None:
        """The sums of terms, then of one candidate after another, or of two."""
        pairs = len(found) == 2
        before = delayed(m, walking, _WALK - 2 + _PAIR * pairs, "before", control=True)
        sloping = register(m, before, "sloping", control=True)
        summing = register(m, sloping, "summing", control=True)
        summed = register(m, summing, "summed", control=True)
        size, excess = self._pair(m, *found) if pairs else (found[0].size, found[0].excess)
        slope = Signal(signed(slope_bits(self._design) + 1), reset_less=True)
        total = Signal.like(self.sums[0], name="total", reset_less=True)
        gain = register(m, (slope << pairs) + excess, "gain")
        counts, quiet = self.i_valid & ~self.first[-1], Signal(init=1)
        with m.If(self.ended):
            m.d.sync += quiet.eq(0)
        with m.If(sloping | counts):
            m.d.sync += slope.eq(slope + Mux(sloping, Cat(size, C(0, 1)).as_signed(), self.step))
        with m.If(summing | counts):
            m.d.sync += total.eq(total + Mux(summing, gain, self.first))
        # Each cleared when it has been used, by a register of its own: this goes to all bits of a word.
        end = register(m, sloping & ~before, "slope_ends", control=True)
        with m.If(end):
            m.d.sync += slope.eq(0)
        with m.If(register(m, end, "sum_ends", control=True)):
            m.d.sync += total.eq(0)
        m.d.comb += self.begins.eq(sloping & ~summing & ~quiet)
        if pairs:
            even = self._design.search.steps % 2 == 0  # then the last candidate comes alone
            odd = register(m, slope + delayed(m, found[0].excess, _PAIR), "odd")
            there = Cat(summing | summed if even else summing, summing) & (~quiet).replicate(2)
            m.d.comb += [
                self.sums[0].eq(register(m, total, "sum0")),
                self.sums[1].eq(register(m, (total + odd)[: len(total)], "sum1")),
                self.valid.eq(register(m, there, "there", control=True)),
            ]
        else:
            m.d.comb += [self.sums[0].eq(total), self.valid.eq((summing | summed) & ~quiet)]

    @staticmethod
    def _pair(m: Module, odd: data.View, even: data.View) -> tuple[Value, Value]:
        """What two entries in turn do to slope and sum, beside what the slope before them does."""
        both = register(m, odd.size + even.size, "both")
        excess, rest = register(m, odd.size + odd.excess, "excess"), register(m, even.excess, "rest")
        return register(m, both, "size"), register(m, excess + rest, "excess")
