"""The sweep's sums: B^z and S of P candidates, one candidate a lane, lane behind lane."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Any

from amaranth import Elaboratable, Module, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.model.design import Design
from tfra.model.fixed.sweep import sweep_unit
from tfra.model.fixed.widths import widths

_WAYS = 8
"""Rows behind one register of the read-out: two levels of 4-input tables."""


def unit_shift(design: Design) -> int:
    """Places between K b and the stress in units of the sums."""
    return (sweep_unit(design) // design.search.steps).bit_length() - 1


def grid_stress(design: Design) -> int:
    """Bits of K b."""
    return widths(design).stress + design.search.steps.bit_length()


def swept_words(design: Design) -> data.StructLayout:
    """One taxel at one candidate: ``x = K p + k q``, ``y = K b - x`` in units of the sums, and the slope q."""
    w = widths(design)
    y = max(w.candidate, grid_stress(design) + unit_shift(design)) + 1
    return data.StructLayout({"x": signed(w.candidate), "y": signed(y), "q": signed(w.vector)})


def swept_taxel(design: Design) -> data.StructLayout:
    """One step of a lane: a taxel if ``valid``; ``ended`` marks the step behind a pass's last taxel."""
    return data.StructLayout({"words": swept_words(design), "valid": 1, "ended": 1})


def row_layout(design: Design) -> data.StructLayout:
    """The sums of one candidate."""
    w = widths(design)
    return data.StructLayout({"z": unsigned(w.b_z), "xy": unsigned(w.b_xy), "valid": 1})


def lanes_latency(design: Design) -> int:
    """Cycles from the end marker at the first lane to the row of candidate 0: levels of the read-out."""
    levels, rows = 0, design.architecture.sweep_lanes
    while rows > 1 or not levels:
        levels, rows = levels + 1, -(-rows // _WAYS)
    return levels


class Lanes(wiring.Component):
    """``z[c] = sum of max(0, x + c q)``, ``xy[c] = sum of max(0, y - c q)`` for c = 0 ... P - 1.

        x, y, q -> lane 0 -> x + q, y - q, q -> lane 1 -> ... -> lane P - 1 -> x + P q, y - P q, q
                     |                            |                 |
                     +------- row if ended -------+---- OR ---------+-> row

    Every lane works on a taxel a cycle later than the lane before, so that rows are complete one a cycle and leave
    in the order of candidates through a tree of ORs, ``lanes_latency`` cycles behind their end marker.  End markers
    are P cycles apart at least.

    A sum never leaves its word for candidates up to K; lanes beyond wrap, each for itself.

    Resources: per lane four adders and five registers of about ``widths.candidate`` to ``widths.b_xy`` bits.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        shape = swept_taxel(design)
        super().__init__({"i": In(shape), "o": Out(shape), "row": Out(row_layout(design))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taxel: Value = self.i
        rows: list[Value] = []
        for number in range(self._design.architecture.sweep_lanes):
            m.submodules[f"lane{number}"] = lane = _Lane(self._design)
            m.d.comb += lane.i.eq(taxel)
            taxel = lane.o
            rows.append(lane.row.as_value())
        m.d.comb += self.o.eq(taxel)
        for _ in range(lanes_latency(self._design)):
            level = []
            for start in range(0, len(rows), _WAYS):
                word = Signal(row_layout(self._design), reset_less=True)
                m.d.sync += word.eq(reduce(or_, rows[start : start + _WAYS]))
                level.append(word.as_value())
            rows = level
        m.d.comb += self.row.eq(rows[0])
        return m


class _Lane(Elaboratable):
    """Sums of one candidate: clock enables choose the positive parts; ``row`` is zero but for the end marker's cycle.

    The end marker clears the sums, so that the next pass's first taxel may come right behind it.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self.i, self.o = Signal(swept_taxel(design)), Signal(swept_taxel(design))
        self.row = Signal(row_layout(design))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        w, i, now = widths(self._design), self.i, self.i.words
        words = Signal(swept_words(self._design), reset_less=True)
        valid, ended = Signal(), Signal()
        m.d.sync += [
            words.x.eq(now.x + now.q),
            words.y.eq(now.y - now.q),
            words.q.eq(now.q),
            valid.eq(i.valid),
            ended.eq(i.ended),
        ]
        z, xy = Signal(w.b_z), Signal(w.b_xy)
        for total, word in ((z, now.x), (xy, now.y)):
            with m.If(i.valid & ~word[-1]):
                m.d.sync += total.eq(total + word[:-1])
            with m.If(i.ended):
                m.d.sync += total.eq(0)
        m.d.comb += [self.o.words.eq(words), self.o.valid.eq(valid), self.o.ended.eq(ended)]
        with m.If(i.ended):
            m.d.comb += [self.row.z.eq(z), self.row.xy.eq(xy), self.row.valid.eq(1)]
        return m
