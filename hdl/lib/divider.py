"""Quotients of magnitudes, one bit a cycle, rounded as :func:`tfra.model.fixed.numbers.divide` rounds."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape
from tfra.hdl.lib.pipeline import register


class Divider(wiring.Component):
    """Non-restoring division: ``quotient = +-round(numerator / denominator * 2^fraction)``, half up, sign last.

    ::

        remainder ─▶ -+ 2^(whole - 1) denominator, towards zero ─┬▶ sign: digit ─▶ quotient, and its neighbour
            ▲                                                    │
            └────────────────── << 1 ◀───────────────────────────┘

    With D = 2^(whole - 1) denominator, step k = 1, 2, ... finds digit d_k of the quotient q_k, from the highest one:

        difference_k = remainder_(k-1) - D      if remainder_(k-1) >= 0, else remainder_(k-1) + D
        remainder_k  = 2 difference_k                                    remainder_0 = numerator
        d_k = 1 if difference_k >= 0, else 0
        q_k = 2 q_(k-1) + d_k                                            q_0 = 0

    Invariant after step k, which each step keeps:

        remainder_k = 2^k numerator - 2 D (2 q_(k-1) + 1)     within -2 D ... 2 D
        q_k = floor(2^(k-1) numerator / D)

    The registers lag by one step: ``quotient`` = s q_(k-1) and ``further`` = s (q_(k-1) + 1), its neighbour one
    unit further from zero, with the sign s.  The last digit, half a unit, selects one of the two, so rounding takes no
    adder and no cycle.  With negative digits the sign takes none either.

    A quotient must be below ``2^whole``, that is ``numerator < 2^whole * denominator``; otherwise it is meaningless,
    but takes the same time.  A denominator of zero gives ``+-2^(whole + fraction)``: all its digits are one.

    The states, in registers:

    ======= ======== ======== ========= ================================================================
    state   ``busy`` ``done`` ``known`` ends with
    ======= ======== ======== ========= ================================================================
    idle    0        0        0         ``i.valid``
    divide  1        0        0, then 1 the use of the last digit; ``known``: there is a digit to be used
    send    1        1        1         ``o.ready``
    ======= ======== ======== ========= ================================================================

    ``numerator`` and ``denominator`` are bits of unsigned magnitudes, ``whole`` and ``fraction`` those of the quotient
    before and after the point, ``whole`` one or more.

    Resources: one addition of ``denominator + whole + 1`` bits, no multiplier.
    """

    def __init__(self, numerator: int, denominator: int, fraction: int, whole: int = 1) -> None:
        self._whole, self._denominator = whole, denominator
        self._digits = whole + fraction + 1
        operands = data.StructLayout(
            {"numerator": unsigned(numerator), "denominator": unsigned(denominator), "negative": 1}
        )
        super().__init__({
            "i": In(stream.Signature(operands)),  # taken when the last quotient has left; ``negative``: its sign
            "o": Out(stream.Signature(signed(self._digits + 1))),  # the quotient, registered
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the operands to that of the quotient: to load, each digit, and the last's use."""
        return self._digits + 2

    @property
    def interval(self) -> int:
        """Cycles from one division to the next; the output of the quotient takes one of them."""
        return self.latency + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        divisor = Signal(self._denominator + self._whole - 1, reset_less=True)  # D
        remainder = Signal(signed(self._denominator + self._whole + 1), reset_less=True)
        negative = Signal(reset_less=True)
        quotient = Signal.like(self.o.payload, name="quotient", reset_less=True)
        further = Signal.like(self.o.payload, name="further", reset_less=True)
        left = Signal(counter_shape(self._digits - 1), reset_less=True)  # steps after this one
        positive = Signal(reset_less=True)  # TIMING: difference -> quotient, further
        digit = positive | register(m, divisor == 0, "vanishing")
        busy = Signal()
        done = Signal()
        known = Signal()
        last = Signal(reset_less=True)  # the digit that is known is the last one
        m.d.comb += self.i.ready.eq(~busy)
        m.d.comb += self.o.valid.eq(done)
        m.d.comb += self.o.payload.eq(quotient)
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
                last.eq(left == 0),
                done.eq(known & last),
            ]
            with m.If(known & last):
                m.d.sync += quotient.eq(Mux(digit, further, quotient))
            with m.Elif(known):
                m.d.sync += self._append(quotient, further, digit, negative)
        with m.Elif(self.o.ready):
            m.d.sync += busy.eq(0)
            m.d.sync += done.eq(0)
            m.d.sync += known.eq(0)
        return m

    @staticmethod
    def _append(quotient: Signal, further: Signal, digit: Value, negative: Value) -> list[Any]:
        """``s q`` and ``s (q + 1)`` become ``s (2 q + digit)`` and ``s (2 q + digit + 1)``, with the sign s.

        One of the two is even, twice one of the words; the odd one is twice the lower of the words, and one.
        """
        lower = Mux(negative, further, quotient)
        return [
            quotient.eq(Cat(digit, Mux(digit, lower, quotient))),
            further.eq(Cat(~digit, Mux(digit, further, lower))),
        ]
