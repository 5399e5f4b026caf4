"""|F*|, mu and the gain F_sens / F*: bit-exact hardware of :mod:`tfra.model.fixed.gain`."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Shape, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, two_steps
from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import delayed, register, zeros_later
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import cordic_latency, cordic_modulus, cordic_vector
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants, normal_gain
from tfra.model.fixed.widths import force_drop

_FINE = 2
"""Bits of a shift by which its second step moves."""

_TOP = 4
"""Cycles from a word to its top bits: two for its length, two for the shift."""


class Gain(wiring.Component):
    """Gain of a frame's forces (Eqs. 15, 29-31).

    ::

        |F_x|, |F_y| -> Cordic -> tangential -+-> Cordic -> modulus -> top bits -> Divider -> mantissa
        |F_z| * gain ---------------> normal -+-> Divider -> mu                   |
        magnitude * gain^2 ------------------------> top bits --------------------+

    One Cordic, the one of :mod:`tfra.hdl.parallel.angle`, and one Divider serve twice each, mu is divided while the
    second run turns, and the constant products are serial and done within the first run.  Every frame takes the same
    time, whether its values are used or not.  Shifts are limited to what their payload holds: a longer one leaves
    nothing of a word anyway.

    ``latency`` cycles from the one in which ``total`` and ``frame`` are valid to the transfer of ``gain``; both
    are taken in the first cycle in which it is valid; one frame every ``latency`` + 2 cycles.  Resources: a Divider,
    two adders, one barrel shifter, no multiplier.

    Members:
        total, frame: streams in, one transfer a frame.
        vector: stream out to the Cordic.
        turned: stream in, the modulus, ``cordic_latency`` cycles after its vector.
        gain: stream out.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        operand, bits = design.formats.operand, design.widths.division
        self._turn = cordic_latency(design)
        # Numerators are below twice their denominators, mu's because it divides by four times the normal force.
        self._divider = Divider(bits + 1, bits + 2, operand - 1)
        super().__init__(
            {
                "total": In(stream.Signature(payloads.total(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "vector": Out(always_ready_stream(cordic_vector(design))),
                "turned": In(always_ready_stream(cordic_modulus(design))),
                "gain": Out(stream.Signature(payloads.gain(design))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the first in which ``total`` and ``frame`` are valid, the block idle, to the ``gain`` transfer.

        Two runs of the Cordic, one division; one cycle each to take magnitudes, to start either run and to start the
        division; ``_TOP`` for the top bits of the modulus.
        """
        return 2 * self._turn + self._divider.latency + 4 + _TOP

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.divider = divider = self._divider
        # From the start of mu's division to that of the second: no state below has to ask for ready.
        assert divider.interval <= self._turn + 3
        design, bits = self._design, self._design.widths.division
        out = Signal(payloads.gain(design), reset_less=True)
        # Tangential forces grow by sqrt(2) times the CORDIC gain, 2.33; the normal force by the gain, 1.65.
        x, y = Signal(bits + 1, reset_less=True), Signal(bits, reset_less=True)
        start, done = Signal(), Signal()
        idle, again, dividing, sending = Signal(init=1), Signal(), Signal(), Signal()  # again: behind the first run
        normal, numerator = self._products(m, start)
        work = Signal(max(len(numerator), len(self.turned.p)), reset_less=True)
        zeros, top = _normalise(m, work, bits)
        top_numerator, numerator_zeros = Signal.like(top, reset_less=True), Signal.like(zeros, reset_less=True)
        modulus_is_zero, unbounded = zeros == len(work), Signal(reset_less=True)
        regular = register(m, self.frame.p.contact & self.frame.p.traction, "regular")

        # The steps of a frame: pulses, each so many cycles behind the one before.
        first, second = self.turned.valid & ~again, self.turned.valid & again
        modulus = register(m, first, "modulus", control=True)
        divide = delayed(m, second, _TOP + 1, "divide", control=True)
        mu, mantissa = divider.o.valid & ~dividing, divider.o.valid & dividing
        m.d.comb += [
            start.eq(idle & self.total.valid & self.frame.valid),
            self.gain.valid.eq(sending),
            self.gain.payload.eq(out),
            self.vector.valid.eq(register(m, start | first, "turn", control=True)),
            self.vector.p.x.eq(x),
            self.vector.p.y.eq(y),
            self.total.ready.eq(done),
            self.frame.ready.eq(done),
            divider.i.valid.eq(modulus | divide),
            divider.i.p.numerator.eq(Mux(again, top_numerator, x)),
            divider.i.p.denominator.eq(Mux(again, top, y << 2)),
            divider.o.ready.eq(1),
        ]
        m.d.sync += [
            idle.eq((idle & ~start) | register(m, self.gain.ready & sending, "sent", control=True)),
            again.eq((again & ~start) | modulus),
            dividing.eq((dividing | divide) & ~mantissa),
            done.eq(mantissa),
            sending.eq(mantissa | (sending & ~self.gain.ready)),
            unbounded.eq(x >= (y << 2)),
        ]
        force_shift, resultant_shift, below = self._shifts(m, numerator_zeros - zeros, regular)

        with m.If(~again):
            m.d.sync += work.eq(numerator)
        with m.Elif(second):
            m.d.sync += [top_numerator.eq(top), numerator_zeros.eq(zeros), work.eq(self.turned.p)]
        with m.If(start):
            m.d.sync += [x.eq(abs(self.total.p.words[0])), y.eq(abs(self.total.p.words[1]))]
        with m.Elif(first):
            m.d.sync += [x.eq(self.turned.p), y.eq(normal)]
        with m.If(mu):
            m.d.sync += out.mu.eq(self._mu(regular, unbounded))
        with m.If(mantissa):
            m.d.sync += [
                out.mantissa.eq(self._mantissa(regular, top_numerator)),
                out.force_shift.eq(_limit(force_shift, out.force_shift.shape())),
                out.resultant_shift.eq(_limit(resultant_shift, out.resultant_shift.shape())),
                out.overflow.eq((regular & (unbounded | modulus_is_zero)) | below),
            ]
        return m

    def _mantissa(self, regular: Value, numerator: Value) -> Value:
        """The quotient, below 2^operand; the Divider answers a modulus of zero with just that limit."""
        operand, quotient = self._design.formats.operand, self._divider.o.payload
        limited = Mux(quotient[operand], numerator[-1].replicate(operand), quotient[:operand])
        return Mux(regular, limited, Const(normal_gain(self._design)[0], operand))

    def _mu(self, regular: Value, unbounded: Value) -> Value:
        """The quotient, below 2^(operand - 1)."""
        sign, quotient = self._design.formats.operand - 1, self._divider.o.payload
        top = Const((1 << sign) - 1, sign)
        return Mux(regular, Mux(unbounded | quotient[sign], top, quotient[:sign]), 0)

    def _products(self, m: Module, start: Value) -> tuple[Value, Value]:
        """|F_z| times the CORDIC gain, magnitude times its square; done before the first run is."""
        design = self._design
        first, second = gain_constants(design)
        digits = max(first, second).bit_length()
        assert digits < self._turn
        left = Signal(counter_shape(digits))
        busy = Signal()  # some are left; a register, since it enables long words
        m.d.sync += busy.eq(start | (busy & (left != 1)))
        with m.If(start):
            m.d.sync += left.eq(digits)
        with m.Elif(busy):
            m.d.sync += left.eq(left - 1)
        z = Signal(design.widths.division, reset_less=True)
        with m.If(start):
            m.d.sync += z.eq(abs(self.total.p.words[2]))
        normal = _serial_product(m, z, first, digits, start, busy)
        numerator = _serial_product(m, self.frame.p.magnitude, second, digits, start, busy)
        return normal[design.formats.operand - 2 :], numerator

    def _shifts(self, m: Module, growth: Value, regular: Value) -> tuple[Value, Value, Value]:
        """Shifts of forces and of resultants, and whether one is negative; they settle while the Divider works.

        ``growth``: by how much the modulus is longer than the numerator.
        """
        design, exponent_total = self._design, self.total.p.exponent
        operand, fraction = design.formats.operand, design.formats.force_fraction
        swept = register(m, register(m, growth) - exponent_total + (2 * operand - 4))
        exponent = register(m, Mux(regular, swept, normal_gain(design)[1]))
        force_shift = register(m, exponent + (2 - force_drop(design) - fraction))
        resultant_shift = register(m, exponent + exponent_total - fraction)
        return force_shift, resultant_shift, (force_shift < 0) | (resultant_shift < 0)


def _serial_product(m: Module, word: Value, constant: int, digits: int, start: Value, busy: Value) -> Value:
    """``word * constant``, a digit of the constant for each ``busy`` cycle after ``start``.

    The product enters the register from above while the constant leaves it below; the word must stay.
    """
    shifter = Signal(len(word) + digits, reset_less=True)
    with m.If(start):
        m.d.sync += shifter.eq(constant)
    with m.Elif(busy):
        total = shifter[digits:] + Mux(shifter[0], word, 0)
        m.d.sync += shifter.eq(Cat(shifter[1:digits], total))
    return shifter


def _normalise(m: Module, work: Value, bits: int) -> tuple[Value, Value]:
    """Zeros above ``work`` two cycles later, and ``_TOP`` later its ``bits`` top bits from the highest one."""
    zeros = register(m, zeros_later(m, work), "length")
    coarse, fine = two_steps(zeros, _FINE)
    moved = register(m, (work << coarse)[max(0, len(work) - bits - (1 << _FINE)) : len(work)], "moved")
    return zeros, register(m, (moved << register(m, fine, "fine"))[len(moved) - bits : len(moved)], "top")


def _limit(value: Value, shape: Shape) -> Value:
    """Signed ``value`` limited to an unsigned ``shape``."""
    bits = Shape.cast(shape).width
    top = Const((1 << bits) - 1, unsigned(bits))
    return Mux(value[-1], 0, Mux(value[bits:].any(), top, value[:bits]))
