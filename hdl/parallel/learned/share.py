"""The resultant over the sum of p: bit-exact hardware of :func:`tfra.model.fixed.learned.share.share`."""

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import NORMALIZE, delayed, driver, normalize, register, wrapping_counter
from tfra.hdl.lib.streams import TOKEN, Tokens, always_ready_stream
from tfra.hdl.parallel.learned.payloads import contact, share, taxel_quad
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.share import even_word

_SUM = 6
"""Cycles from a frame's last quad to the sum of p: the quad, each of its words, and their sum."""
_DIVIDE = NORMALIZE + 1
"""Cycles from there to the first division: the top bits, and a register for the denominator."""


class Share(wiring.Component):
    """A mantissa for each axis of a frame, and their shift.

    ::

        p -> a word a cycle, each taxel once -> sum -> top bits ---> Divider -> share
                                                  '-> length -> shift -'

    One Divider, used for F_x, F_y and F_z in turn; a frame at a time, for which there is a token.  No multiplier.
    """

    def __init__(self, design: LearnedDesign) -> None:
        bits, scalar = design.widths.division, design.formats.bits("scalar")
        self._design, self._sum_bits = design, max(bits, total_bits(design, design.widths))
        self._divider = Divider(bits, bits, scalar - 1)
        super().__init__({
            # Q quads of mirror taxels a frame, at least four cycles apart, for which the token was taken.
            "p": In(always_ready_stream(taxel_quad(design))),
            # Fact of the frame, there before its last quad, taken with its last mantissa.
            "contact": In(stream.Signature(contact(design))),
            # Three transfers a frame; at most ``FRAMES`` frames' are on their way.
            "share": Out(always_ready_stream(share(design))),
            "share_token": Out(stream.Signature(TOKEN)),  # one token
        })

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a frame's last quad to that of its first mantissa: four words and their sum."""
        return _SUM + _DIVIDE + self._divider.latency + 1

    @property
    def interval(self) -> int:
        """Cycles from a mantissa to the next."""
        return self._divider.interval

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.share_tokens = tokens = Tokens(1)
        wiring.connect(m, tokens.o, wiring.flipped(self.share_token))
        total, complete = self._sum(m)
        denominator, shift, even = self._denominator(m, total)
        last = self._divide(m, delayed(m, complete, _DIVIDE, "divide", control=True), denominator, shift, even)
        m.d.comb += tokens.give.eq(last)
        return m

    def _sum(self, m: Module) -> tuple[Value, Value]:
        """Sum of p over the taxels, each of them once; high when it is complete."""
        design, bits = self._design, self._design.widths.force - 1
        sensor = design.sensor
        words = Signal(4 * bits, reset_less=True)
        total = Signal(self._sum_bits, reset_less=True)
        column, row_ends = wrapping_counter(m, self.p.valid, design.quad_columns, "column")
        row, frame_ends = wrapping_counter(m, self.p.valid & row_ends, design.quad_rows, "row")
        # On the middle line of an odd count the two mirror taxels are the same one.
        single_x = Const(sensor.columns % 2, 1) & row_ends
        single_y = Const(sensor.rows % 2, 1) & frame_ends
        counts = Signal(4)
        word = Signal(bits, reset_less=True)
        first = Signal(reset_less=True)
        adding = Signal(4)  # bit k: the quad came k + 1 cycles ago
        m.d.sync += adding.eq(adding << 1)
        m.d.sync += words.eq(words >> bits)
        m.d.sync += counts.eq(counts >> 1)
        with m.If(self.p.valid):
            m.d.sync += [
                words.eq(Cat(word[:bits] for word in self.p.p)),  # none of them is negative
                counts.eq(Cat(1, ~single_x, ~single_y, ~single_x & ~single_y)),  # by place, the first of its taxel
                adding.eq(1),
            ]
        m.d.sync += word.eq(Mux(counts[0], words[:bits], 0))
        starts = register(m, self.p.valid & (column == 0) & (row == 0), "starts")
        m.d.sync += first.eq(starts)
        with m.If(register(m, adding.any(), "summing", control=True)):
            m.d.sync += total.eq(Mux(first, 0, total) + word)
        return total, delayed(m, self.p.valid & frame_ends & row_ends, _SUM, "last_quad", control=True)

    def _denominator(self, m: Module, total: Value) -> tuple[Signal, Signal, Signal]:
        """Top bits of the sum, the shift, and whether they are those of taxels that are all alike.

        The shift is the length of the sum plus what the resultant alone determines.
        """
        design, fmt = self._design, self._design.formats
        bits, taxels = design.widths.division, design.sensor.taxels
        alike = taxels * even_word(design)
        zeros, top = normalize(m, total, bits)
        settled = fmt.bits("scalar") - 2 + fmt.vector_fraction - fmt.force_fraction - (bits - 1)
        base = register(m, self.contact.p.total.exponent + settled, "base")
        exact = register(m, base + (len(total) - zeros), "exact_shift")
        vanishing = register(m, zeros == len(total), "vanishing")
        even = register(m, vanishing | (exact < 0), "even")
        denominator = Signal(bits, reset_less=True)
        shift = Signal(self.share.p.shift.shape(), reset_less=True)
        length = alike.bit_length()
        alike_top = alike << (bits - length) if length <= bits else alike >> (length - bits)
        m.d.sync += [
            denominator.eq(Mux(even, alike_top, top)),
            shift.eq(Mux(even, base + length, register(m, exact, "exact_shift_later"))),
        ]
        return denominator, shift, register(m, even, "even_later")

    def _divide(self, m: Module, start: Value, denominator: Value, shift: Value, even: Value) -> Value:
        """The three divisions; high with the last quotient."""
        m.submodules.divider = divider = self._divider
        top = (1 << (self._design.formats.bits("scalar") - 1)) - 1
        sent = driver(m, self.share.payload)
        done, quotient = divider.o.valid, divider.o.payload
        axis, last = wrapping_counter(m, done, 3, "axis")
        force = Array(self.contact.p.total.words[k] for k in range(3))[axis]
        m.d.comb += [
            divider.i.valid.eq(start | register(m, done & ~last, "again", control=True)),
            divider.i.p.numerator.eq(abs(force)),
            divider.i.p.denominator.eq(denominator),
            divider.i.p.negative.eq(force[-1]),
            divider.o.ready.eq(1),
            self.contact.ready.eq(done & last),
            self.share.valid.eq(register(m, done, "share_valid", control=True)),
        ]
        m.d.sync += [
            sent.mantissa.eq(Mux(quotient > top, top, Mux(quotient < -top, -top, quotient))),
            sent.shift.eq(shift),
            sent.even.eq(even),
        ]
        return done & last
