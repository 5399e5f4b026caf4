"""Pipelines at narrow widths: the sweep's winner, the CORDIC."""

from types import SimpleNamespace
from typing import Any

from amaranth import Array, Cat, Const, Mux, Signal, Value, signed

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from tfra.hdl.parallel.cordic import ENTRY_GUARD, Cordic, cordic_latency
from tfra.hdl.parallel.tfra.sweep.sums import at_once, rows
from tfra.hdl.parallel.tfra.sweep.terms import unit_shift
from tfra.hdl.parallel.tfra.sweep.winner import _SMALLER, Winner, winner_latency
from tfra.model.fixed.tfra.sweep import tolerance

FOUND = "the winner comes when stated"
PLATEAU, NEAREST, FIRST = "it is on the plateau of B^z", "none there has a smaller B^xy", "of equals it is the first"


def narrow(steps: int, pairs: bool, slack: float) -> Any:
    """What a winner asks of a design of ``steps`` + 1 candidates, with words of few bits."""
    design: Any = SimpleNamespace(
        search=SimpleNamespace(steps=steps, tolerance=slack),
        cycles_per_quad=1 if pairs else 2,
        adc=SimpleNamespace(bits=2),
        formats=SimpleNamespace(vector_fraction=0),
        widths=SimpleNamespace(b_z=4, magnitude=1),
    )
    design.widths.b_xy = design.widths.magnitude + steps.bit_length() + unit_shift(design)
    return design


def winner(steps: int, pairs: bool, slack: float = 0.0) -> Any:
    """Frames whose rows come without a gap, one after the other has been decided."""
    design = narrow(steps, pairs, slack)
    ways, last_row, count = at_once(design), rows(design), steps + 1
    end = last_row + winner_latency(design)

    def setup(bench: Bench, Block: Any) -> None:
        block = Block(design)
        inner = bench.place(block)
        m = bench.m
        cycle = Signal(range(end + 1))
        go = bench.free(1, "go")
        m.d.sync += cycle.eq(Mux(cycle == end, 0, Mux(cycle == 0, go, cycle + 1)))
        for way in range(ways):
            there = [row for row in range(last_row) if row * ways + way < count]
            bench.assume(block.valid[way] == Cat(cycle == row + 1 for row in there).any())
        same = (cycle <= 1) | (
            (block.measured == bench.past(block.measured)) & (block.exponent == bench.past(block.exponent))
        )
        bench.assume(same)
        bench.assume(block.exponent < design.adc.bits)
        z = Array(Signal(design.widths.b_z, name=f"z{k}") for k in range(count))
        xy = Array(Signal(design.widths.b_xy, name=f"xy{k}") for k in range(count))
        for k in range(count):
            row = block.rows[k % ways]
            with m.If(cycle == k // ways + 1):
                m.d.sync += z[k].eq(row.z)
                m.d.sync += xy[k].eq(abs(row.xy - (block.measured << unit_shift(design))))
        lowest: Value = z[0]
        for k in range(1, count):
            lowest = Mux(z[k] < lowest, z[k], lowest)
        limit = lowest + Array(int(each) for each in tolerance(design))[block.exponent]
        on = [z[k] <= limit for k in range(count)]
        bench.claim(FOUND, cycle == end, block.found)
        bench.claim(PLATEAU, block.found, z[block.index] <= limit)
        bench.claim(NEAREST, block.found, Cat(~on[k] | (xy[k] >= xy[block.index]) for k in range(count)).all())
        earlier = Cat(~on[k] | (k >= block.index) | (xy[k] > xy[block.index]) for k in range(count))
        bench.claim(FIRST, block.found, earlier.all())
        place = cycle - 1 - _SMALLER * (ways - 1)  # of the row that is compared
        bench.lemma(inner["none"] == ~((place >= 1) & (place < last_row)))
        bench.lemma(inner["row_number"] == Mux((place >= 0) & (place < last_row), place, 0))
        bench.lemma(inner["row_number_last"] == (inner["row_number"] == last_row - 1))

    return setup


_MUTANTS = {
    FOUND: ("latency = winner_latency(self._design) - wait", "latency = winner_latency(self._design) - wait + 1"),
    PLATEAU: ("falls = none | less(z, value)", "falls = none"),
    NEAREST: ("less(distance, best)", "less(best, distance)"),
    FIRST: ("less(distance, best)", "~less(best, distance)"),
}


def winners() -> list[Proof]:
    """One candidate at a time or two, with a tolerance and without."""
    proofs = []
    for steps, pairs, slack in ((3, False, 0.0), (3, True, 0.0), (2, True, 0.0), (3, False, 0.1), (2, True, 0.1)):
        design = narrow(steps, pairs, slack)
        cycles = rows(design) + winner_latency(design)
        size = f"{steps + 1} candidates{', pairs' if pairs else ''}{', a tolerance' if slack else ''}"
        proofs.append(Proof(Winner, winner(steps, pairs, slack), _MUTANTS, cycles + 2, cycles + 3, size=size))
    return proofs


_ROTATIONS, _WORD, _WITHIN = 5, 6, 4
"""Of the CORDIC; bits of a coordinate; units that the modulus may be off."""
_GAIN, _PLACES = 693, 8
"""Square of the CORDIC gain of these rotations, and its places after the point."""


def cordic(bench: Bench, Block: Any) -> None:
    """Any vector in any cycle: the words, in adders that are long enough for certain, and the modulus."""
    design: Any = SimpleNamespace(
        widths=SimpleNamespace(division=_WORD - ENTRY_GUARD), formats=SimpleNamespace(bits=lambda _: _ROTATIONS)
    )
    block = Block(design)
    bench.place(block)
    latency, shape, m = cordic_latency(design), block.vector.payload.shape(), bench.m
    past = [shape(bench.past(Value.cast(block.vector.payload), cycles)) for cycles in range(1, latency + 1)]
    entered = bench.past(Const(1, 1), latency)
    bench.claim("a modulus for each vector", bench.past(block.vector.valid, latency), block.turned.valid)
    bench.claim("as longer adders have it", entered, block.turned.payload == _rotated(bench, past[-1], _ROTATIONS)[0])
    signs = Cat(_rotated(bench, vector, number)[1] < 0 for number, vector in enumerate(past[:-1]))
    bench.claim("and the sign of each rotation", entered, block.negative == signs)
    vector, turned = past[-1], block.turned.payload
    square, most, least = Signal(32), Signal(32), Signal(32)
    m.d.comb += square.eq((vector.x * vector.x + vector.y * vector.y) * _GAIN)
    m.d.comb += most.eq((turned + _WITHIN) * (turned + _WITHIN) << _PLACES)
    m.d.comb += least.eq(Mux(turned > _WITHIN, (turned - _WITHIN) * (turned - _WITHIN) << _PLACES, 0))
    bench.claim("the modulus within four units", entered, (least <= square) & (square <= most))


def _rotated(bench: Bench, vector: Any, rotations: int) -> tuple[Value, Value]:
    """``vector`` after some ``rotations``, in words that are longer than any coordinate."""
    left = vector.x < 0
    x, y = Mux(left, -vector.x, vector.x), Mux(left, -vector.y, vector.y)
    for number in range(rotations):
        word_x, word_y = (Signal(signed(2 * _WORD)) for _ in "xy")
        bench.m.d.comb += [word_x.eq(x), word_y.eq(y)]
        up = word_y < 0
        x = Mux(up, word_x - (word_y >> number), word_x + (word_y >> number))
        y = Mux(up, word_y + (word_x >> number), word_y - (word_x >> number))
    return x, y


_CORDIC = {
    "a modulus for each vector": ('cordic_latency(self._design), "valid"', 'cordic_latency(self._design) - 1, "valid"'),
    "as longer adders have it": ("min(bits, bits - number + 2)", "min(bits, bits - number - 1)"),
    "and the sign of each rotation": ("self.negative[number].eq(up)", "self.negative[number].eq(x[-1])"),
    "the modulus within four units": ("add_or_subtract(x, y >> number, up)", "add_or_subtract(x, y >> number, ~up)"),
}

PROOFS = [
    *winners(),
    Proof(Cordic, cordic, _CORDIC, depth=_ROTATIONS + 2, size=f"{_ROTATIONS} rotations of {_WORD} bits"),
]
