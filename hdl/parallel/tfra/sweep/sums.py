"""The sweep's sums: B^z, or S of B^xy, of every candidate, in their order, one or two a cycle."""

from typing import Any, NamedTuple

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import READ, delayed, register
from tfra.hdl.parallel.tfra.sweep.accumulator import DRAIN, Accumulator
from tfra.hdl.parallel.tfra.sweep.crossing import Crossing, crossing_latency
from tfra.model.fixed.design import Design

_PAIR = 2
"""Extra cycles where entries are taken in pairs, to add the effects of both on the slope and on the sum."""


def at_once(design: Design) -> int:
    """Candidates whose sums are ready in a cycle: two in a core that processes a whole quad in one cycle."""
    return 2 if design.cycles_per_quad == 1 else 1


def rows(design: Design) -> int:
    """Cycles in which the sums of all candidates come."""
    return design.search.steps // at_once(design) + 1


def _reads(design: Design) -> int:
    """Entries of a bank: candidates 1 ... K take turns among the banks."""
    return -(-design.search.steps // at_once(design))


def _first_sum(design: Design) -> int:
    """Cycles from the end mark, which comes a cycle after the last term, to the sum of candidate 0 in its register."""
    return crossing_latency(design) + DRAIN + READ + _PAIR * (at_once(design) - 1) + 1


def first_row(design: Design) -> int:
    """Cycles from the end mark to the first row; a pair of sums has a register more."""
    return _first_sum(design) + at_once(design) - 1


def sums_wait(design: Design) -> int:
    """Cycles from a frame's last term to the next frame's first at the earliest: the sums of all candidates."""
    return _first_sum(design) + _reads(design) + 2


def slope_bits(design: Design) -> int:
    """Bits of the sum of all |q|."""
    return design.widths.vector - 1 + design.sensor.taxels.bit_length()


class _Phases(NamedTuple):
    """Operations on slope and sum in a cycle."""

    slope_adds: Value
    """The size of an entry is added to the slope."""
    slope_ends: Value
    """The slope has been used and is cleared.  TIMING: slope_adds -> slope"""
    sum_adds: Value
    """A candidate's gain is added to the sum."""
    sum_added: Value
    """One has been added in the cycle before."""
    sum_ends: Value
    """The sum has been used and is cleared.  TIMING: slope_ends -> total"""


class Sums(wiring.Component):
    """``sum(k) = sum over terms of max(0, first + k step)`` for k = 0 ... K; exact.

    A term counts while it is positive, from k = 0 up to its crossing or from there on, so the sum is convex and linear
    between crossings:

        sum(0)   = sum of first >= 0                       sum(k)   = sum(k-1) + slope(k-1) + excess of crossings at k
        slope(0) = sum of their steps                      slope(k) = slope(k-1) + size of crossings at k

    ::

        first, step -+-> slope(0), sum(0) ------------------------> slope, sum of one candidate after another -> sums
                     '-> Crossing -> Accumulator of K entries ------^
                                     size, excess

    Each term takes a cycle, and each candidate one or half a cycle, instead of terms times candidates.  For two
    candidates a cycle, odd and even entries have a bank each, and a pair of entries moves slope and sum at once:

        slope(k+2) = slope(k) + (size(k+1) + size(k+2))
        sum(k+2)   = sum(k) + 2 slope(k) + (excess(k+1) + size(k+1) + excess(k+2))

    Cycles after the read of entry 1; in brackets after that of the pair of entries 1 and 2.  The entries after it
    follow in the cycles after it:

    ======= ================ ===========================================================
    cycle   phase            registers
    ======= ================ ===========================================================
    2 (4)   ``slope_adds``   ``slope`` is slope(0), and takes the entry's size
    3 (5)   ``sum_adds``     ``total`` is sum(0), and takes ``gain``: slope(0) and excess
    4 (6)   ``sum_added``    ``total`` is sum(1), or sum(2) of a pair
    ======= ================ ===========================================================

    No term comes from ``ended`` until the sums have come: see :func:`sums_wait`.  After a reset entries, slope and
    total are cleared in the same way, without any sum that is ``valid``.

    Resources: a :class:`Crossing`, an :class:`Accumulator` of K entries of about 80 bits, five adders; for two
    candidates a cycle seven more.
    """

    def __init__(self, design: Design, first_bits: int, sum_bits: int) -> None:
        self._design, self._pairs = design, at_once(design) == 2
        super().__init__({
            "first": In(signed(first_bits)),  # the term of candidate 0
            "step": In(signed(design.widths.vector)),  # its increment from one candidate to the next
            "size": In(unsigned(design.widths.vector)),  # ``|step|``
            "i_valid": In(1),  # there is a term in this cycle
            "ended": In(1),  # pulse, a cycle after a frame's last term
            # The sums of the next ``at_once`` candidates, those of a frame without a gap.
            "sums": Out(unsigned(sum_bits)).array(at_once(design)),
            "valid": Out(at_once(design)),  # which of them are there; after the last candidate there is none
            "begins": Out(1),  # pulse, a cycle ahead of candidate 0, or two where they come in pairs
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crossing = crossing = Crossing(self._design, len(self.first))
        m.d.comb += [
            crossing.first.eq(self.first),
            crossing.rises.eq(~self.step[-1]),
            crossing.i_size.eq(self.size),
            crossing.i_valid.eq(self.i_valid),
        ]
        # Those of candidates 1 ... K have the addresses 0 ... K - 1.
        fields = {"size": crossing.size, "excess": crossing.excess}
        entries = Accumulator(
            m,
            data.StructLayout(dict.fromkeys(fields, unsigned(slope_bits(self._design)))),
            self._design.search.steps,
            at_once(self._design),
            address=crossing.before,
            value=fields,
            valid=crossing.valid,
            drain=delayed(m, self.ended, crossing_latency(self._design), "crossings_end", control=True),
        )
        when = self._phases(m, entries.draining)
        if self._pairs:
            size, excess = self._pair(m, *entries.rows)
        else:
            size, excess = entries.rows[0].size, entries.rows[0].excess
        slope = self._slope(m, when, size)
        total = self._total(m, when, slope, excess)
        self._send(m, when, total, slope, entries.rows[0].excess)
        return m

    def _phases(self, m: Module, draining: Value) -> _Phases:
        """Operations on slope and sum, after the reads of entries."""
        next_adds = delayed(m, draining, READ - 1 + _PAIR * self._pairs, "next_adds", control=True)
        slope_adds = register(m, next_adds, "slope_adds", control=True)
        sum_adds = register(m, slope_adds, "sum_adds", control=True)
        sum_added = register(m, sum_adds, "sum_added", control=True)
        slope_ends = register(m, slope_adds & ~next_adds, "slope_ends", control=True)
        sum_ends = register(m, slope_ends, "sum_ends", control=True)
        return _Phases(slope_adds, slope_ends, sum_adds, sum_added, sum_ends)

    def _slope(self, m: Module, when: _Phases, size: Value) -> Signal:
        """The steps of terms that count at candidate 0, then with the size of one entry after another."""
        slope = Signal(signed(slope_bits(self._design) + 1), reset_less=True)
        with m.If(when.slope_adds | self._counts()):
            m.d.sync += slope.eq(slope + Mux(when.slope_adds, Cat(size, Const(0, 1)).as_signed(), self.step))
        with m.If(when.slope_ends):
            m.d.sync += slope.eq(0)
        return slope

    def _total(self, m: Module, when: _Phases, slope: Signal, excess: Value) -> Signal:
        """The sum of candidate 0, then of one candidate after another, or of every other one."""
        total = Signal.like(self.sums[0], name="total", reset_less=True)
        gain = register(m, (slope << self._pairs) + excess, "gain")
        with m.If(when.sum_adds | self._counts()):
            m.d.sync += total.eq(total + Mux(when.sum_adds, gain, self.first))
        with m.If(when.sum_ends):
            m.d.sync += total.eq(0)
        return total

    def _counts(self) -> Value:
        """A term that is positive at candidate 0."""
        return self.i_valid & ~self.first[-1]

    def _send(self, m: Module, when: _Phases, total: Signal, slope: Signal, odd_excess: Value) -> None:
        """Sums of a row; where they come in pairs, the odd candidate's is made from that of the even one before it."""
        clearing = Signal(init=1)  # the entries being read belong to no frame, after a reset
        with m.If(self.ended):
            m.d.sync += clearing.eq(0)
        odd = when.sum_adds
        even = when.sum_adds
        if rows(self._design) > _reads(self._design):  # the last candidate is even, and comes after all entries
            even = when.sum_adds | when.sum_added
        valid = Cat(even, odd)[: len(self.valid)] & (~clearing).replicate(len(self.valid))
        m.d.comb += self.begins.eq(when.slope_adds & ~when.sum_adds & ~clearing)
        if self._pairs:
            odd_gain = register(m, slope + delayed(m, odd_excess, _PAIR, "odd_excess"), "odd_gain")
            m.d.comb += [
                self.sums[0].eq(register(m, total, "even_sum")),
                self.sums[1].eq(register(m, (total + odd_gain)[: len(total)], "odd_sum")),
                self.valid.eq(register(m, valid, "sums_valid", control=True)),
            ]
        else:
            m.d.comb += self.sums[0].eq(total)
            m.d.comb += self.valid.eq(valid)

    @staticmethod
    def _pair(m: Module, odd: Any, even: Any) -> tuple[Value, Value]:
        """The effect of two consecutive entries on slope and sum, without that of the slope before them; ``_PAIR``
        later."""
        both = register(m, odd.size + even.size, "both_sizes")
        odd_part = register(m, odd.size + odd.excess, "odd_part")
        even_part = register(m, even.excess, "even_part")
        return register(m, both, "size"), register(m, odd_part + even_part, "excess")
