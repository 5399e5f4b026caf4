"""The sweep's winner among all candidates, from their sums."""

from typing import Any, NamedTuple

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, less
from tfra.hdl.lib.pipeline import delayed, driver, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.tfra.sweep.sums import at_once, rows
from tfra.hdl.parallel.tfra.sweep.terms import measured_sum, unit_shift
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.sweep import tolerance

_DISTANCE = 2
"""Cycles from a row to its B^xy: difference, magnitude."""
_REPLAY = 3
"""Cycles from the read of a row to its comparison: memory, its register, comparison with the limit."""
_SMALLER = 2
"""Cycles in which the smaller of two words is found: comparison, choice."""


def winner_latency(design: Design) -> int:
    """Cycles from the last row to the pulse ``found``; all rows once more if there is a tolerance."""
    pair = at_once(design) - 1
    again = rows(design) - 1 + _REPLAY + _SMALLER * pair if tolerance(design).any() else 0
    return _DISTANCE + 1 + _SMALLER * pair + again


class _Lowest(NamedTuple):
    """The smallest B^z so far, aligned with the row that is compared with it."""

    z: Value
    """B^z of the row, the smaller one of a pair."""
    value: Signal
    """The smallest B^z of the rows before."""
    falls: Value
    """The row's is smaller, or the first of its frame."""


class Winner(wiring.Component):
    """The candidate with the smallest B^xy on the plateau of B^z, the first of equals.

    The plateau is all candidates whose B^z is within the tolerance of the smallest one.  Three registers:

        ``lowest``   the smallest B^z so far
        ``best``     the smallest B^xy on the plateau so far
        ``index``    its candidate

    ::

        z -----------> lowest --> on the plateau? -.
        xy -- minus measured sum -- |.| -- B^xy ---+--> best, index

    Without a tolerance a smaller B^z begins a new plateau, and an equal one belongs to it: candidates are compared as
    they come.  With a tolerance the plateau is known only after all candidates: they wait in a memory and are compared
    as they leave it, while those of the next frame replace them.  Where candidates come in pairs, the better one of a
    pair is selected first, and represents both.

    Resources: two comparators, two adders; with a tolerance a memory of all candidates, a comparator and an adder more;
    for pairs all of that twice, and two comparators.
    """

    def __init__(self, design: Design) -> None:
        self._design, self._ways = design, at_once(design)
        row = data.StructLayout({"z": unsigned(design.widths.b_z), "xy": unsigned(design.widths.b_xy)})
        super().__init__({
            "rows": In(row).array(self._ways),  # the sums of the candidates of a cycle
            "valid": In(self._ways),  # which of them are there
            # K times the sum of positive stress, from the first row until the last one is compared.
            "measured": In(unsigned(measured_sum(design))),
            # Exponent of the frame, which the tolerance depends on; as long.
            "exponent": In(payloads.frame_facts(design)["exponent"].shape),
            "found": Out(1),  # a pulse, ``winner_latency`` cycles after the last row
            "index": Out(payloads.sweep_index(design)),  # the winner, while ``found``
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        wait = _SMALLER * (self._ways - 1)  # until the smaller B^z of a pair is known
        second, equal, z = self._smaller_z(m)
        valid = delayed(m, self.valid[0], wait, "row_valid", control=True)
        number, last = wrapping_counter(m, valid, rows(self._design), "row_number")
        lowest = self._lowest(m, z, valid, last)
        distances = self._distances(m)
        distance_number = delayed(m, number, _DISTANCE - wait, "distance_number")
        if tolerance(self._design).any():
            complete = register(m, valid & last, "complete", control=True)
            self._compare_later(m, distances, distance_number, self._limit(m, lowest.value, complete), complete)
        else:
            distance, place = self._smaller_xy(m, distances, distance_number, second, equal)
            self._compare_now(m, distance, place, lowest, valid)
        latency = winner_latency(self._design) - wait
        m.d.comb += self.found.eq(delayed(m, valid & last, latency, "found", control=True))
        return m

    def _smaller_z(self, m: Module) -> tuple[Value, Value, Value]:
        """Of a pair, ``_SMALLER`` later: the second B^z is smaller, both are equal, the smaller one."""
        first, other, there = self.rows[0].z, self.rows[-1].z, self.valid[-1]
        if self._ways == 1:
            return Const(0, 1), Const(0, 1), first
        second = register(m, there & (other < first), "second_is_smaller")
        difference = register(m, other ^ first, "z_difference")
        other = register(m, other, "second_z")
        first = register(m, first, "first_z")
        z = register(m, Mux(second, other, first), "smaller_z")
        equal = register(m, register(m, there, "second_is_there") & ~difference.any(), "pair_is_equal")
        return register(m, second, "second_counts"), equal, z

    def _lowest(self, m: Module, z: Value, valid: Value, last: Value) -> _Lowest:
        """The smallest B^z of a frame's rows until now."""
        value = Signal(len(z), name="lowest", reset_less=True)
        none = Signal(init=1)  # no row of this frame has come
        falls = none | less(z, value)
        with m.If(falls):  # words that are not valid come before the first row, which replaces them
            m.d.sync += value.eq(z)
        with m.If(valid):
            m.d.sync += none.eq(last)
        return _Lowest(z, value, falls)

    def _distances(self, m: Module) -> list[Value]:
        """B^xy of the candidates: ``|xy - measured|`` in units of the sums, ``_DISTANCE`` later."""
        bits = self._design.widths.b_xy
        distances: list[Value] = []
        for way, row in enumerate(self.rows):
            difference = Signal(signed(bits + 1), name=f"difference{way}", reset_less=True)
            distance = Signal(bits, name=f"distance{way}", reset_less=True)
            m.d.sync += [
                difference.eq(row.xy - (self.measured << unit_shift(self._design))),
                distance.eq((difference ^ difference[-1].replicate(bits + 1)) + difference[-1]),
            ]
            distances.append(distance)
        return distances

    def _smaller_xy(
        self, m: Module, distances: list[Value], number: Value, second: Value, equal: Value
    ) -> tuple[Value, Value]:
        """A pair's smaller B^xy and its candidate, ``_SMALLER`` later; ``second`` where only that one counts."""
        if self._ways == 1:
            return distances[0], number
        take = register(m, second | (equal & (distances[1] < distances[0])), "take_second")
        first = register(m, distances[0], "first_xy")
        other = register(m, distances[1], "second_xy")
        smaller = register(m, Mux(take, other, first), "smaller_xy")
        return smaller, register(m, Cat(take, register(m, number, "pair_number")), "candidate")

    def _compare_now(self, m: Module, distance: Value, candidate: Value, lowest: _Lowest, valid: Value) -> None:
        """Without a tolerance: a smaller B^z begins a new plateau, an equal one is on it."""
        above = register(m, less(lowest.value, lowest.z), "above")
        on_plateau = register(m, valid, "compared") & ~above
        begins = delayed(m, valid & lowest.falls, _DISTANCE, "begins")
        self._keep_best(m, distance, candidate, delayed(m, on_plateau, _DISTANCE - 1, "on_plateau"), begins)

    def _keep_best(self, m: Module, distance: Value, candidate: Value, on_plateau: Value, begins: Value) -> None:
        """The first smallest B^xy of those on the plateau, which ``begins`` anew with this one."""
        best = Signal(len(distance), reset_less=True)
        index = driver(m, self.index)
        with m.If(begins | (on_plateau & less(distance, best))):
            m.d.sync += best.eq(distance)
            m.d.sync += index.eq(candidate)

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

    def _compare_later(self, m: Module, distances: list[Value], number: Value, limit: Value, complete: Value) -> None:
        """With a tolerance: keep the rows until all have come, then compare with the plateau's limit."""
        stored = data.StructLayout({"xy": len(distances[0]), "z": len(self.rows[0].z), "there": 1})
        words = []
        for distance, row, there in zip(distances, self.rows, self.valid, strict=True):
            words.append(Cat(distance, delayed(m, Cat(row.z, there), _DISTANCE, "z_later")))
        number, words_read, turning = self._replay(m, number, Cat(words), complete)
        row = data.View(data.ArrayLayout(stored, self._ways), words_read)
        on = [register(m, turning & word.there & (word.z <= limit), "on_plateau", control=True) for word in row]
        replayed: list[Value] = [register(m, word.xy, f"replayed{way}") for way, word in enumerate(row)]
        number = register(m, number, "replayed_number")
        distance, candidate = self._smaller_xy(m, replayed, number, on[-1] & ~on[0], on[-1] & on[0])
        some = delayed(m, Cat(on).any(), _SMALLER * (self._ways - 1), "some_on_plateau", control=True)
        begun = Signal()  # one on the plateau has been compared
        with m.If(complete):
            m.d.sync += begun.eq(0)
        with m.Elif(some):
            m.d.sync += begun.eq(1)
        self._keep_best(m, distance, candidate, some, some & ~begun)

    def _replay(self, m: Module, number: Value, row: Value, complete: Value) -> tuple[Value, Value, Value]:
        """Store every row; when all have arrived, replay them: number, words and valid.

        The first is read in the cycle after ``complete`` and comes ``_REPLAY - 1`` later.
        """
        last, wait = rows(self._design) - 1, _REPLAY - 1
        stored = Ram(m, "rows", unsigned(len(row)), max(2, last + 1))
        read_number = Signal(counter_shape(last))
        reading = Signal()
        with m.If(reading):
            m.d.sync += read_number.eq(read_number + 1)
            m.d.sync += reading.eq(read_number != last)
        with m.If(complete):
            m.d.sync += read_number.eq(0)
            m.d.sync += reading.eq(1)
        stored.write(delayed(m, self.valid[0], _DISTANCE, "store", control=True), number, row)
        return (
            delayed(m, read_number, wait, "read_number_later"),
            delayed(m, stored.read(read_number), wait - 1, "row_read"),
            delayed(m, reading, wait, "row_valid", control=True),
        )
