"""|F*|, mu and the gain F_sens / F*: bit-exact hardware of :mod:`tfra.model.fixed.gain`."""

from typing import Any, NamedTuple

from amaranth import Const, Module, Mux, Shape, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import NORMALIZE, busy_after, delayed, normalize, register, serial_product
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import cordic_latency, cordic_modulus, cordic_vector
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.gain import gain_constants, normal_gain
from tfra.model.fixed.widths import force_drop


class _States(NamedTuple):
    """The state during the words of a frame: a register, and pulses in the order of time."""

    second_run: Value
    start: Value
    first: Value
    divide_mu: Value
    second: Value
    divide_mantissa: Value
    mu: Value
    mantissa: Value


class _Tops(NamedTuple):
    """Top bits of numerator and modulus, from the highest one that is set."""

    numerator: Value
    modulus: Value
    growth: Value
    """Bits by which the modulus is longer than the numerator."""
    modulus_is_zero: Value


class Gain(wiring.Component):
    """Gain of a frame's forces (Eqs. 15, 29-31).

    ::

        |F_x|, |F_y| -> Cordic -> tangential -+-> Cordic -> modulus -> top bits -> Divider -> mantissa
        |F_z| * gain ---------------> normal -+-> Divider -> mu                   |
        magnitude * gain^2 ------------------------> top bits --------------------+

    One Cordic, the one of :mod:`tfra.hdl.parallel.angle`, and one Divider are used twice each.  mu is divided during
    the second run; the constant products are serial and finish within the first run.  Every frame takes the same time,
    whether its values are used or not.  Shifts are limited to what their payload holds: a longer one leaves nothing of
    a word anyway.

    The states, in registers of their own:

    ========== ======== ============== ============ =========== ======================================================
    state      ``idle`` ``second_run`` ``dividing`` ``sending`` ends with
    ========== ======== ============== ============ =========== ======================================================
    idle       1        any            0            0           ``start``: ``total`` and ``frame`` are valid
    first run  0        0              0            0           ``first``, the tangential force; a cycle later
                                                                ``divide_mu`` begins mu's division
    second run 0        1              0            0           ``second``, the modulus of F; ``NORMALIZE + 1`` later
                                                                ``divide_mantissa`` begins the mantissa's division
    division   0        1              1            0           ``mantissa``, its quotient
    sending    0        1              0            1           ``gain.ready``; idle again a cycle later
    ========== ======== ============== ============ =========== ======================================================

    A frame every ``latency + 2`` cycles.  Resources: a Divider, two adders, one barrel shifter, no multiplier.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        bits = design.widths.division
        self._turn = cordic_latency(design)
        # Numerators are below twice their denominators, mu's because it divides by four times the normal force.
        self._divider = Divider(bits + 1, bits + 2, design.formats.bits("scalar") - 1)
        super().__init__({
            # One transfer a frame, taken in the first cycle in which ``gain`` is valid.
            "total": In(stream.Signature(payloads.total(design))),
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, taken with ``total``
            "vector": Out(always_ready_stream(cordic_vector(design))),  # to the Cordic
            # The modulus, ``cordic_latency`` cycles after its vector.
            "turned": In(always_ready_stream(cordic_modulus(design))),
            "gain": Out(stream.Signature(payloads.gain(design))),  # one transfer a frame
        })

    @property
    def latency(self) -> int:
        """Cycles from the first in which ``total`` and ``frame`` are valid, the block idle, to the ``gain`` transfer.

        Two runs of the Cordic, one division; one cycle each to take magnitudes, to start either run and to start the
        division; ``NORMALIZE`` for the top bits of the modulus.
        """
        return 2 * self._turn + self._divider.latency + 4 + NORMALIZE

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.divider = self._divider
        state = self._states(m)
        normal, numerator = self._products(m, state.start)
        x, y = self._vector(m, state, normal)
        regular = register(m, self.frame.p.contact & self.frame.p.traction, "regular")
        unbounded = register(m, x >= (y << 2), "unbounded")
        tops = self._top_bits(m, state, numerator)
        self._divide(m, state, tops, x, y)
        self._send(m, state, tops, regular, unbounded)
        return m

    def _states(self, m: Module) -> _States:
        """The registers of the state, and the pulses that end it."""
        # From the start of mu's division to that of the mantissa's: no state has to check the divider's ready.
        assert self._divider.interval <= self._turn + 3
        idle = Signal(init=1)
        second_run = Signal()
        dividing = Signal()
        sending = Signal()
        done = Signal()
        start = Signal()
        quotient = self._divider.o.valid
        first, second = self.turned.valid & ~second_run, self.turned.valid & second_run
        divide_mu = register(m, first, "divide_mu", control=True)
        divide_mantissa = delayed(m, second, NORMALIZE + 1, "divide_mantissa", control=True)
        mu, mantissa = quotient & ~dividing, quotient & dividing
        m.d.comb += [
            start.eq(idle & self.total.valid & self.frame.valid),
            self.gain.valid.eq(sending),
            self.vector.valid.eq(register(m, start | first, "turn", control=True)),
            self.total.ready.eq(done),
            self.frame.ready.eq(done),
        ]
        m.d.sync += [
            idle.eq((idle & ~start) | register(m, self.gain.ready & sending, "sent", control=True)),
            second_run.eq((second_run & ~start) | divide_mu),
            dividing.eq((dividing | divide_mantissa) & ~mantissa),
            done.eq(mantissa),
            sending.eq(mantissa | (sending & ~self.gain.ready)),
        ]
        return _States(second_run, start, first, divide_mu, second, divide_mantissa, mu, mantissa)

    def _vector(self, m: Module, state: _States, normal: Value) -> tuple[Signal, Signal]:
        """|F_x|, |F_y| for the first run; the tangential and the normal force for the second and for mu."""
        bits = self._design.widths.division
        # Tangential forces grow by sqrt(2) times the CORDIC gain, 2.33; the normal force by the gain, 1.65.
        x = Signal(bits + 1, reset_less=True)
        y = Signal(bits, reset_less=True)
        with m.If(state.start):
            m.d.sync += x.eq(abs(self.total.p.words[0]))
            m.d.sync += y.eq(abs(self.total.p.words[1]))
        with m.Elif(state.first):
            m.d.sync += x.eq(self.turned.p)
            m.d.sync += y.eq(normal)
        m.d.comb += self.vector.p.x.eq(x)
        m.d.comb += self.vector.p.y.eq(y)
        return x, y

    def _top_bits(self, m: Module, state: _States, numerator: Value) -> _Tops:
        """Top bits of the numerator, kept while those of the modulus are found in the same way."""
        bits = self._design.widths.division
        work = Signal(max(len(numerator), len(self.turned.p)), reset_less=True)
        zeros, top = normalize(m, work, bits)
        numerator_top = Signal.like(top, name="numerator_top", reset_less=True)
        numerator_zeros = Signal.like(zeros, name="numerator_zeros", reset_less=True)
        with m.If(~state.second_run):
            m.d.sync += work.eq(numerator)
        with m.Elif(state.second):
            m.d.sync += numerator_top.eq(top)
            m.d.sync += numerator_zeros.eq(zeros)
            m.d.sync += work.eq(self.turned.p)
        return _Tops(numerator_top, top, numerator_zeros - zeros, zeros == len(work))

    def _divide(self, m: Module, state: _States, tops: _Tops, x: Value, y: Value) -> None:
        """mu's operands before the second run, then the mantissa's."""
        divider = self._divider
        m.d.comb += [
            divider.i.valid.eq(state.divide_mu | state.divide_mantissa),
            divider.i.p.numerator.eq(Mux(state.second_run, tops.numerator, x)),
            divider.i.p.denominator.eq(Mux(state.second_run, tops.modulus, y << 2)),
            divider.o.ready.eq(1),
        ]

    def _send(self, m: Module, state: _States, tops: _Tops, regular: Value, unbounded: Value) -> None:
        """Write quotients, shifts and flags to ``gain`` as they arrive."""
        gain = Signal(payloads.gain(self._design), name="sent", reset_less=True)
        force_shift, resultant_shift, below = self._shifts(m, tops.growth, regular)
        m.d.comb += self.gain.payload.eq(gain)
        with m.If(state.mu):
            m.d.sync += gain.mu.eq(self._mu(regular, unbounded))
        with m.If(state.mantissa):
            m.d.sync += [
                gain.mantissa.eq(self._mantissa(regular, tops.numerator)),
                gain.force_shift.eq(_limit(force_shift, gain.force_shift.shape())),
                gain.resultant_shift.eq(_limit(resultant_shift, gain.resultant_shift.shape())),
                gain.overflow.eq((regular & (unbounded | tops.modulus_is_zero)) | below),
            ]

    def _mantissa(self, regular: Value, numerator: Value) -> Value:
        """The quotient, below 2^bits; for a modulus of zero the Divider gives exactly that limit."""
        bits, quotient = self._design.formats.bits("scalar"), self._divider.o.payload
        limited = Mux(quotient[bits], numerator[-1].replicate(bits), quotient[:bits])
        return Mux(regular, limited, Const(normal_gain(self._design)[0], bits))

    def _mu(self, regular: Value, unbounded: Value) -> Value:
        """The quotient, below 2^sign."""
        sign, quotient = self._design.formats.bits("scalar") - 1, self._divider.o.payload
        top = Const((1 << sign) - 1, sign)
        return Mux(regular, Mux(unbounded | quotient[sign], top, quotient[:sign]), 0)

    def _products(self, m: Module, start: Value) -> tuple[Value, Value]:
        """|F_z| times the CORDIC gain, magnitude times its square; done before the first run is."""
        design = self._design
        first, second = gain_constants(design)
        digits = max(first, second).bit_length()
        assert digits < self._turn
        busy = busy_after(m, start, digits)
        z = Signal(design.widths.division, reset_less=True)
        with m.If(start):
            m.d.sync += z.eq(abs(self.total.p.words[2]))
        normal = serial_product(m, z, first, digits, start, busy, "normal")
        numerator = serial_product(m, self.frame.p.magnitude, second, digits, start, busy, "numerator")
        return normal[iterations(design) - 2 :], numerator

    def _shifts(self, m: Module, growth: Value, regular: Value) -> tuple[Value, Value, Value]:
        """Shifts of forces and of resultants, and whether one is negative; they settle while the Divider works."""
        design, exponent_total = self._design, self.total.p.exponent
        bits, fraction = design.formats.bits("scalar"), design.formats.force_fraction
        settled = (bits - 1) + (iterations(design) - 3)  # of the quotient, and of its numerator
        swept = register(m, register(m, growth, "growth") - exponent_total + settled, "swept_exponent")
        exponent = register(m, Mux(regular, swept, normal_gain(design)[1]), "exponent")
        force_shift = register(m, exponent + (2 - force_drop(design) - fraction), "force_shift")
        resultant_shift = register(m, exponent + exponent_total - fraction, "resultant_shift")
        return force_shift, resultant_shift, (force_shift < 0) | (resultant_shift < 0)


def _limit(value: Value, shape: Shape) -> Value:
    """Signed ``value`` limited to an unsigned ``shape``."""
    bits = Shape.cast(shape).width
    top = Const((1 << bits) - 1, unsigned(bits))
    return Mux(value[-1], 0, Mux(value[bits:].any(), top, value[:bits]))
