"""The candidate at which a term of the sweep changes its sign: a pipelined divider, one term a cycle."""

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
    """The first candidate k at which the sign of ``first + k step`` differs from that of ``first``; zero is positive.

    With ``t = first`` or, where that is negative, ``-first - 1``, and ``size = |step|``,

        before = floor(t / size),    excess = |first + (before + 1) step| = size - t mod size  or one less,

    by non-restoring division, one quotient bit a stage: ``before`` is the last candidate with the sign of ``first``.
    Invariant after the stage of bit b, with the bits q of ``before`` above it:

        remainder = t - 2^b size (2 q + 1)     within -2^b size ... 2^b size;     bit b = (remainder >= 0)

    A crossing from 1 to K is ``valid``; the others belong to terms that keep their sign.

    Resources: per quotient bit an adder of ``step``'s bits, and three more.
    """

    def __init__(self, design: Design, first_bits: int) -> None:
        self._design = design
        step = design.widths.vector
        super().__init__({
            "first": In(signed(first_bits)),  # the term of candidate 0
            "rises": In(1),  # its step is positive
            "i_size": In(unsigned(step)),  # magnitude of its step
            "i_valid": In(1),  # there is a term in this cycle
            # The candidate before its crossing, ``crossing_latency`` cycles later.
            "before": Out(counter_shape(design.search.steps - 1)),
            "size": Out(unsigned(step)),  # magnitude of its step, valid with ``before``
            "excess": Out(unsigned(step)),  # magnitude of the term at its crossing, valid with ``before``
            "valid": Out(1),  # there is a crossing
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits, negative = quotient_bits(self._design), self.first[-1]
        size = register(m, self.i_size, "first_size")
        distance = register(m, (self.first ^ negative.replicate(len(self.first)))[:-1], "distance")
        crosses = register(m, self.i_valid & (negative == self.rises), "crosses", control=True)
        falls = delayed(m, ~negative, 2 + bits, "falls")
        remainder = register(m, distance - (size << bits), "remainder")
        size = register(m, size, "size")
        inside: Value = register(m, crosses, "inside", control=True) & remainder[-1]  # before < 2^bits
        quotient: Value = Const(0, 1)
        for bit in reversed(range(bits)):
            inside = register(m, inside, f"inside{bit}", control=True)
            quotient = register(m, quotient, f"quotient{bit}")
            remainder = register(m, self._divide(remainder, size, bit), f"remainder{bit}")
            size = register(m, size, f"size{bit}")
            quotient = Cat(~remainder[-1], quotient)[:bits]
        # t mod size is the remainder or, below zero, the remainder plus size.
        m.d.sync += [
            driver(m, self.excess).eq(add_carry(Mux(remainder[-1], 0, size), (~remainder)[: len(size)], falls)),
            driver(m, self.size).eq(size),
            driver(m, self.before).eq(quotient),
            self.valid.eq(inside & (quotient < self._design.search.steps)),
        ]
        return m

    def _divide(self, remainder: Value, size: Value, bit: int) -> Value:
        """``remainder`` within ``size << bit`` of zero, from one within twice as much."""
        low = remainder[: len(size) + bit + 2].as_signed()
        divisor = Cat(Const(0, bit), size, Const(0, 1)).as_signed()
        return add_or_subtract(low, divisor, ~low[-1])[: len(size) + bit + 1].as_signed()
