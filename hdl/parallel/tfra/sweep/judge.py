"""The sweep's choice among all candidates, from their sums."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, less
from tfra.hdl.lib.pipeline import delayed, driver, register, wrapping_counter
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.tfra.sweep.sums import at_once, rows
from tfra.hdl.parallel.tfra.sweep.terms import measured_sum, unit_shift
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.sweep import tolerance

_DISTANCE = 2
"""Cycles from a row to its B^xy: difference, magnitude."""
_REPLAY = 3
"""Cycles from the read of a row to its turn: memory, its register, comparison with the limit."""
_SMALLER = 2
"""Cycles in which the smaller of two words is found: comparison, choice."""


def row_layout(design: Design) -> data.StructLayout:
    """The sums of one candidate."""
    w = design.widths
    return data.StructLayout({"z": unsigned(w.b_z), "xy": unsigned(w.b_xy)})


def judge_latency(design: Design) -> int:
    """Cycles from the last row to the pulse ``found``; all rows once more if there is a tolerance."""
    pair = at_once(design) - 1
    again = rows(design) - 1 + _REPLAY + _SMALLER * pair if tolerance(design).any() else 0
    return _DISTANCE + 1 + _SMALLER * pair + again


class Judge(wiring.Component):
    """Choose: smallest B^xy of those within the tolerance of the smallest B^z, the first of equals.

    ::

        z -----------> smallest so far? --> plateau --.
        xy -- minus measured sum -- |.| -- B^xy ------+--> smallest of the plateau so far --> index

    Without a tolerance a smaller B^z begins a new plateau, and an equal one belongs to it: candidates are judged as
    they come.  With a tolerance the plateau is known when all have come: they wait in a memory and are judged from
    there, while those of the next frame take their places.  Where candidates come in pairs, the better one of a pair
    is found first, and stands for both.

    Resources: two comparators, two adders; with a tolerance a memory of all candidates, a comparator and an adder more;
    for pairs all of that twice, and two comparators.

    Members:
        rows, valid: the candidates of a cycle, and which of them are there.
        measured, exponent: K times the sum of positive stress, and the frame's exponent.
        found, index: a pulse, while the index stands.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._ways = design, at_once(design)
        super().__init__(
            {
                "rows": In(row_layout(design)).array(self._ways),
                "valid": In(self._ways),
                "measured": In(unsigned(measured_sum(design))),
                "exponent": In(payloads.frame_facts(design)["exponent"].shape),
                "found": Out(1),
                "index": Out(payloads.sweep_index(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pair = self._ways - 1
        wait = _SMALLER * pair  # until the smaller B^z of a pair is there
        second, equal, z = self._smaller(m)
        valid = delayed(m, self.valid[0], wait, control=True)
        number, last = wrapping_counter(m, valid, rows(self._design))
        lowest, none = Signal(len(z), reset_less=True), Signal(init=1)  # none: of this frame
        lower = none | less(z, lowest)
        with m.If(lower):  # what is not valid comes before the first
            m.d.sync += lowest.eq(z)
        with m.If(valid):
            m.d.sync += none.eq(last)
        distances, place = self._distances(m), delayed(m, number, _DISTANCE - wait)
        if tolerance(self._design).any():
            complete = register(m, valid & last, control=True)
            self._plateau(m, distances, place, self._limit(m, lowest, complete), complete)
        else:
            distance, place = self._better(m, distances, place, second, equal)
            on = register(m, valid) & ~register(m, less(lowest, z), "above")
            fresh, on = delayed(m, valid & lower, _DISTANCE), delayed(m, on, _DISTANCE - 1)
            self._best(m, distance, place, on, fresh)
        found = delayed(m, valid & last, judge_latency(self._design) - wait, control=True)
        m.d.comb += self.found.eq(found)
        return m

    def _smaller(self, m: Module) -> tuple[Value, Value, Value]:
        """Of a pair, two cycles later: the second B^z is smaller, both are equal, the smaller one."""
        first, other, there = self.rows[0].z, self.rows[-1].z, self.valid[-1]
        if self._ways == 1:
            return Const(0, 1), Const(0, 1), first
        second, differ = register(m, there & (other < first), "second"), register(m, other ^ first, "differ")
        z = register(m, Mux(second, register(m, other), register(m, first)), "smaller")
        return register(m, second), register(m, register(m, there) & ~differ.any(), "equal"), z

    def _distances(self, m: Module) -> list[Signal]:
        """B^xy of the candidates."""
        bits = self._design.widths.b_xy
        distances = []
        for row in self.rows:
            difference, distance = Signal(signed(bits + 1), reset_less=True), Signal(bits, reset_less=True)
            m.d.sync += [
                difference.eq(row.xy - (self.measured << unit_shift(self._design))),
                distance.eq((difference ^ difference[-1].replicate(bits + 1)) + difference[-1]),
            ]
            distances.append(distance)
        return distances

    def _better(
        self, m: Module, distances: list[Value], place: Value, second: Value, equal: Value
    ) -> tuple[Value, Value]:
        """A pair's smaller distance and its candidate, ``_SMALLER`` later; ``second`` where only that one counts."""
        if self._ways == 1:
            return distances[0], place
        take = register(m, second | (equal & (distances[1] < distances[0])), "take")
        first, other = (register(m, distance) for distance in distances)
        return register(m, Mux(take, other, first)), register(m, Cat(take, register(m, place)))

    def _best(self, m: Module, distance: Value, place: Value, on: Value, fresh: Value) -> None:
        """The first smallest distance of those ``on`` the plateau, which begins anew with a ``fresh`` one."""
        best, index = Signal(len(distance), reset_less=True), driver(m, self.index)
        with m.If(fresh | (on & less(distance, best))):
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

    def _rows(self, m: Module, place: Value, row: Value, complete: Value) -> tuple[Value, Value, Value]:
        """Keep every row; when all are there, hand out places, words and marks, a cycle ahead of their turn."""
        last, wait = rows(self._design) - 1, _REPLAY - 1
        m.submodules.rows = memory = Memory(shape=unsigned(len(row)), depth=max(2, last + 1), init=[])
        write, read = memory.write_port(), memory.read_port()
        turn, turning = Signal(counter_shape(last)), Signal()
        with m.If(turning):
            m.d.sync += [turn.eq(turn + 1), turning.eq(turn != last)]
        with m.If(complete):
            m.d.sync += [turn.eq(0), turning.eq(1)]
        m.d.comb += [
            write.addr.eq(place),
            write.data.eq(row),
            write.en.eq(delayed(m, self.valid[0], _DISTANCE, control=True)),
            read.addr.eq(turn),
            read.en.eq(1),
        ]
        return delayed(m, turn, wait), delayed(m, read.data, wait - 1), delayed(m, turning, wait, control=True)

    def _plateau(self, m: Module, distances: list[Value], place: Value, limit: Value, complete: Value) -> None:
        """Judge what has been kept; the first on the plateau is fresh."""
        kept = data.StructLayout({"xy": len(distances[0]), "z": len(self.rows[0].z), "there": 1})
        come = zip(distances, self.rows, self.valid, strict=True)
        words = [Cat(distance, delayed(m, Cat(row.z, there), _DISTANCE)) for distance, row, there in come]
        place, found, turning = self._rows(m, place, Cat(words), complete)
        row = data.View(data.ArrayLayout(kept, self._ways), found)
        on = [register(m, turning & word.there & (word.z <= limit), "on", control=True) for word in row]
        distances, place = [register(m, word.xy) for word in row], register(m, place)
        distance, place = self._better(m, distances, place, on[-1] & ~on[0], on[-1] & on[0])
        begun, some = Signal(), delayed(m, Cat(on).any(), _SMALLER * (self._ways - 1), control=True)
        with m.If(complete):
            m.d.sync += begun.eq(0)
        with m.Elif(some):
            m.d.sync += begun.eq(1)
        self._best(m, distance, place, some, some & ~begun)
