"""Where a term of the sweep changes its sign: a divider that takes one term a cycle."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Value, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_carry, add_or_subtract, counter_shape
from tfra.hdl.lib.pipeline import delayed, driver, register
from tfra.model.fixed.design import Design


def quotient_bits(design: Design) -> int:
    """Bits of the last candidate but one."""
    return (design.search.steps - 1).bit_length()


def crossing_latency(design: Design) -> int:
    """Cycles from a term to its crossing: magnitudes, comparison with the last candidate, quotient, excess."""
    return 3 + quotient_bits(design)


class Crossing(wiring.Component):
    """The first candidate k at which ``first + k step`` has another sign than ``first``, zero being positive.

    With ``t = first`` or, where that is negative, ``-first - 1``, and ``size = |step|``,

        before = floor(t / size),    excess = |first + (before + 1) step| = size - t mod size  or one less,

    by division without restoring, a quotient bit a stage: ``before`` is the last candidate with the sign of ``first``.
    A crossing from 1 to K is ``valid``; the others are those of terms which keep their sign.

    Members:
        first, rises, i_size, i_valid: a term; whether its step is positive, and the step's magnitude.
        before, size, excess, valid: its crossing, ``crossing_latency`` cycles later.

    Resources: per quotient bit an adder of ``step``'s bits, and three more.
    """

    def __init__(self, design: Design, first_bits: int) -> None:
        self._design = design
        step = design.widths.vector
        super().__init__(
            {
                "first": In(signed(first_bits)),
                "rises": In(1),
                "i_size": In(unsigned(step)),
                "i_valid": In(1),
                "before": Out(counter_shape(design.search.steps - 1)),
                "size": Out(unsigned(step)),
                "excess": Out(unsigned(step)),
                "valid": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        stages, negative = quotient_bits(self._design), self.first[-1]
        size = register(m, self.i_size, "size")
        distance = register(m, (self.first ^ negative.replicate(len(self.first)))[:-1], "distance")
        crosses = register(m, self.i_valid & (negative == self.rises), "crosses", control=True)
        falls = delayed(m, ~negative, 2 + stages, "falls")
        rest, size = register(m, distance - (size << stages), "rest"), register(m, size, "size")
        inside: Value = register(m, crosses, "inside", control=True) & rest[-1]
        quotient: Value = Const(0, 1)
        for bit in reversed(range(stages)):
            inside, quotient = register(m, inside, "inside", control=True), register(m, quotient, "quotient")
            rest, size = register(m, self._divide(rest, size, bit), "rest"), register(m, size, "size")
            quotient = Cat(~rest[-1], quotient)[:stages]
        m.d.sync += [
            driver(m, self.excess).eq(add_carry(Mux(rest[-1], 0, size), (~rest)[: len(size)], falls)),
            driver(m, self.size).eq(size),
            driver(m, self.before).eq(quotient),
            self.valid.eq(inside & (quotient < self._design.search.steps)),
        ]
        return m

    def _divide(self, rest: Value, size: Value, bit: int) -> Value:
        """``rest`` within ``size << bit`` of zero, from one within twice as much."""
        low = rest[: len(size) + bit + 2].as_signed()
        divisor = Cat(Const(0, bit), size, Const(0, 1)).as_signed()
        return add_or_subtract(low, divisor, ~low[-1])[: len(size) + bit + 1].as_signed()
