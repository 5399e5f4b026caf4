"""The sweep's choice among all candidates, from their sums."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import delayed, driver, register, walk
from tfra.hdl.sweep_terms import measured_sum, unit_shift
from tfra.model.design import Design
from tfra.model.fixed.sweep import tolerance
from tfra.model.fixed.widths import widths

_DISTANCE = 2
"""Cycles from a row to its B^xy: difference, magnitude."""
_REPLAY = 3
"""Cycles from the read of a row to its turn: memory, its register, comparison with the limit."""


def row_layout(design: Design) -> data.StructLayout:
    """The sums of one candidate."""
    w = widths(design)
    return data.StructLayout({"z": unsigned(w.b_z), "xy": unsigned(w.b_xy), "valid": 1})


def judge_latency(design: Design) -> int:
    """Cycles from the row of the last candidate to the pulse ``found``; all rows once more if there is a tolerance."""
    again = design.search.steps + _REPLAY if tolerance(design).any() else 0
    return _DISTANCE + 1 + again


class Judge(wiring.Component):
    """Choose: smallest B^xy of those within the tolerance of the smallest B^z, the first of equals.

    ::

        z -----------> smallest so far? --> plateau --.
        xy -- minus measured sum -- |.| -- B^xy ------+--> smallest of the plateau so far --> index

    Without a tolerance a smaller B^z begins a new plateau, and an equal one belongs to it: rows are judged as they
    come.  With a tolerance the plateau is known when all rows are: they wait in a memory and are judged from there,
    while rows of the next frame take their places.

    Resources: two comparators, two adders; with a tolerance a memory of K + 1 rows, a comparator and an adder more.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "row": In(row_layout(design)),
                "measured": In(unsigned(measured_sum(design))),
                "exponent": In(payloads.frame_facts(design)["exponent"].shape),
                "found": Out(1),  # a pulse, while index stands
                "index": Out(payloads.sweep_index(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        z, valid = self.row.z, self.row.valid
        number, last = walk(m, valid, self._design.candidates)
        lowest = Signal(len(z), reset_less=True)
        lower = valid & ((number == 0) | (z < lowest))
        with m.If(lower):
            m.d.sync += lowest.eq(z)
        distance, place = self._distance(m), delayed(m, number, _DISTANCE)
        if tolerance(self._design).any():
            complete = register(m, valid & last, control=True)
            rows = self._rows(m, place, Cat(distance, delayed(m, z, _DISTANCE)), valid, complete)
            self._plateau(m, rows, self._limit(m, lowest, complete), complete)
        else:
            fresh, equal = delayed(m, lower, _DISTANCE), delayed(m, valid & (z == lowest), _DISTANCE)
            self._best(m, distance, place, equal, fresh)
        m.d.comb += self.found.eq(delayed(m, valid & last, judge_latency(self._design), control=True))
        return m

    def _distance(self, m: Module) -> Signal:
        """B^xy of the row."""
        bits = widths(self._design).b_xy
        difference, distance = Signal(signed(bits + 1), reset_less=True), Signal(bits, reset_less=True)
        m.d.sync += [
            difference.eq(self.row.xy - (self.measured << unit_shift(self._design))),
            distance.eq((difference ^ difference[-1].replicate(bits + 1)) + difference[-1]),
        ]
        return distance

    def _best(self, m: Module, distance: Value, place: Value, on: Value, fresh: Value) -> None:
        """The first smallest distance of the rows ``on`` the plateau, which begins anew with a ``fresh`` one."""
        best, index = Signal(len(distance), reset_less=True), driver(m, self.index)
        with m.If(fresh | (on & (distance < best))):
            m.d.sync += [best.eq(distance), index.eq(place)]

    def _limit(self, m: Module, lowest: Value, complete: Value) -> Signal:
        """The largest B^z of the plateau."""
        slack = Signal(len(lowest), reset_less=True)
        limit = Signal(len(lowest) + 1, reset_less=True)
        with m.Switch(self.exponent):
            for exponent, value in enumerate(tolerance(self._design)):
                with m.Case(exponent):
                    m.d.sync += slack.eq(int(value))
        with m.If(complete):
            m.d.sync += limit.eq(lowest + slack)
        return limit

    def _rows(self, m: Module, place: Value, row: Value, valid: Value, complete: Value) -> tuple[Value, Value, Value]:
        """Keep every row; when all are there, hand out places, words and marks, a cycle ahead of their turn."""
        last, wait = self._design.search.steps, _REPLAY - 1
        m.submodules.rows = rows = Memory(shape=unsigned(len(row)), depth=last + 1, init=[])
        write, read = rows.write_port(), rows.read_port()
        turn, turning = Signal(count(last)), Signal()
        with m.If(turning):
            m.d.sync += [turn.eq(turn + 1), turning.eq(turn != last)]
        with m.If(complete):
            m.d.sync += [turn.eq(0), turning.eq(1)]
        m.d.comb += [
            write.addr.eq(place),
            write.data.eq(row),
            write.en.eq(delayed(m, valid, _DISTANCE, control=True)),
            read.addr.eq(turn),
            read.en.eq(1),
        ]
        return delayed(m, turn, wait), delayed(m, read.data, wait - 1), delayed(m, turning, wait, control=True)

    def _plateau(self, m: Module, rows: tuple[Value, Value, Value], limit: Value, complete: Value) -> None:
        """Judge the kept rows; the first on the plateau is fresh."""
        place, words, turning = rows
        bits = widths(self._design).b_xy
        on, begun = Signal(), Signal()
        m.d.sync += on.eq(turning & (words[bits:] <= limit))
        with m.If(complete):
            m.d.sync += begun.eq(0)
        with m.Elif(on):
            m.d.sync += begun.eq(1)
        self._best(m, delayed(m, words[:bits], 1), delayed(m, place, 1), on, on & ~begun)
