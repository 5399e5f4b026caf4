"""Quotients of magnitudes, one bit a cycle, rounded as :func:`tfra.model.fixed.numbers.divide` rounds."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape
from tfra.hdl.lib.pipeline import register


class Divider(wiring.Component):
    """Division without restoring: ``quotient = +-round(numerator / denominator * 2^fraction)``, half up, sign last.

    ::

        remainder ─▶ -+ 2^(whole - 1) denominator, towards zero ─┬▶ sign: digit ─▶ quotient, and its neighbour
            ▲                                                    │
            └────────────────── << 1 ◀───────────────────────────┘

    Beside the quotient its neighbour one unit further from zero is kept, digit for digit.  The last digit, half a
    unit, picks one of the two: rounding takes no adder and no cycle.  With negative digits the sign takes none either.

    A quotient must be below ``2^whole``, that is ``numerator < 2^whole * denominator``; otherwise it is meaningless,
    but takes the same time.  A denominator of zero gives ``+-2^(whole + fraction)``.

    Arguments:
        numerator, denominator: bits of the unsigned magnitudes.
        fraction: fraction bits of the quotient.
        whole: bits before the point, one or more.

    Members: ``i``: ``numerator``, ``denominator`` and ``negative``, the quotient's sign; ``o``: the quotient,
    ``whole + fraction + 2`` bits, registered.  The next division is taken when the last quotient has left.

    Resources: one addition of ``denominator + whole + 1`` bits, no multiplier.
    """

    def __init__(self, numerator: int, denominator: int, fraction: int, whole: int = 1) -> None:
        self._whole, self._denominator = whole, denominator
        self._digits = whole + fraction + 1
        operands = data.StructLayout(
            {"numerator": unsigned(numerator), "denominator": unsigned(denominator), "negative": 1}
        )
        quotient = signed(self._digits + 1)
        super().__init__({"i": In(stream.Signature(operands)), "o": Out(stream.Signature(quotient))})

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the operands to that of the quotient: to load, each digit, and the last's use."""
        return self._digits + 2

    @property
    def interval(self) -> int:
        """Cycles from one division to the next: the quotient leaves in one of its own."""
        return self.latency + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        divisor = Signal(self._denominator + self._whole - 1, reset_less=True)
        remainder = Signal(signed(self._denominator + self._whole + 1), reset_less=True)  # within twice the divisor
        negative = Signal(reset_less=True)
        quotient = Signal.like(self.o.payload, reset_less=True)
        further = Signal.like(self.o.payload, reset_less=True)
        left = Signal(counter_shape(self._digits - 1), reset_less=True)
        # A digit is used a cycle after it is found: sign of a long difference, it has two long words to turn.
        # Without a divisor all digits are one, whatever becomes of the remainder.
        positive, known, ends = Signal(reset_less=True), Signal(), Signal(reset_less=True)
        digit = positive | register(m, divisor == 0, "vanishing")
        busy, done = Signal(), Signal()
        m.d.comb += [self.i.ready.eq(~busy), self.o.valid.eq(done), self.o.payload.eq(quotient)]

        difference = add_or_subtract(remainder, Cat(divisor, 0).as_signed(), ~remainder[-1])
        with m.If(~busy):
            operands = self.i.payload
            m.d.sync += [
                busy.eq(self.i.valid),
                divisor.eq(operands.denominator << (self._whole - 1)),
                remainder.eq(operands.numerator),
                negative.eq(operands.negative),
                quotient.eq(0),
                further.eq(Mux(operands.negative, -1, 1)),
                left.eq(self._digits - 1),
            ]
        with m.Elif(~done):
            m.d.sync += [
                remainder.eq(difference << 1),
                positive.eq(~difference[-1]),
                known.eq(1),
                left.eq(left - 1),
                ends.eq(left == 0),
                done.eq(known & ends),
            ]
            with m.If(known & ends):
                m.d.sync += quotient.eq(Mux(digit, further, quotient))
            with m.Elif(known):
                # 2 q + s digit and 2 q + s digit + s for the sign s, from q and q + s
                lower = Mux(negative, further, quotient)
                m.d.sync += [
                    quotient.eq(Cat(digit, Mux(digit, lower, quotient))),
                    further.eq(Cat(~digit, Mux(digit, further, lower))),
                ]
        with m.Elif(self.o.ready):
            m.d.sync += [busy.eq(0), done.eq(0), known.eq(0)]
        return m
