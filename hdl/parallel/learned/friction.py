"""mu, mu_x and mu_y: bit-exact hardware of :func:`tfra.model.fixed.learned.friction.friction`."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.divider import Divider
from tfra.hdl.lib.pipeline import busy_after, driver, register, serial_product
from tfra.hdl.lib.streams import TOKEN, Tokens, always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.cordic import cordic_latency, cordic_modulus
from tfra.hdl.parallel.learned.payloads import friction
from tfra.model.fixed.cordic import iterations
from tfra.model.fixed.gain import gain_constants
from tfra.model.fixed.learned.design import LearnedDesign


class Friction(wiring.Component):
    """The three quotients of the resultant and its normal force.

    ::

        |F_x|, |F_y| -------> Divider, Divider -> mu_x, mu_y
        modulus ------------> Divider ----------> mu
        |F_z| * CORDIC gain ----'

    The first two divisions and the serial product are done before the last division is.  Every frame takes the same
    time; a frame at a time, for which there is a token.  Quotients are below four: the denominators are four times the
    normal force.  Resources: three Dividers, no multiplier.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        self._fraction = design.formats.bits("scalar") - 1
        super().__init__({
            # The resultant, one transfer a frame, for which the token was taken.
            "force": In(always_ready_stream(payloads.total(design))),
            # One transfer a frame, ``cordic_latency`` cycles later.
            "modulus": In(always_ready_stream(cordic_modulus(design))),
            "friction": Out(always_ready_stream(friction(design))),  # one a frame; stays until the next
            "scalars_token": Out(stream.Signature(TOKEN)),  # one token
        })
        bits = design.widths.division
        self._dividers = {
            "mu_x": Divider(bits, bits + 2, self._fraction),
            "mu_y": Divider(bits, bits + 2, self._fraction),
            "mu": Divider(len(self.modulus.p), bits + 2, self._fraction),
        }

    @property
    def latency(self) -> int:
        """Cycles from the transfer of ``force`` to that of ``friction``: the CORDIC, a division, its result."""
        return cordic_latency(self._design) + self._dividers["mu"].latency + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.scalars_tokens = tokens = Tokens(1)
        wiring.connect(m, tokens.o, wiring.flipped(self.scalars_token))
        sizes = [Signal(self._design.widths.division, name=f"size_{axis}", reset_less=True) for axis in "xyz"]
        signs = [Signal(name=f"negative_{axis}", reset_less=True) for axis in "xy"]
        with m.If(self.force.valid):
            m.d.sync += [size.eq(abs(word)) for size, word in zip(sizes, self.force.p.words, strict=True)]
            m.d.sync += [sign.eq(word[-1]) for sign, word in zip(signs, self.force.p.words, strict=False)]
        start = register(m, self.force.valid, "start", control=True)
        modulus = self.modulus
        operands = {
            "mu_x": (start, sizes[0], sizes[2], signs[0]),
            "mu_y": (start, sizes[1], sizes[2], signs[1]),
            "mu": (modulus.valid, modulus.payload, self._normal(m, sizes[2]), Const(0, 1)),
        }
        sent = driver(m, self.friction.payload)
        limited = []
        done = self._dividers["mu"].o.valid
        for name, operand in operands.items():
            m.submodules[f"{name}_divider"] = self._dividers[name]
            quotient, unbounded = self._divide(m, self._dividers[name], done, *operand)
            limited.append(unbounded)
            with m.If(done):
                m.d.sync += sent[name].eq(quotient)
        with m.If(done):
            m.d.sync += sent.overflow.eq(Cat(limited).any())
        m.d.comb += [
            self.friction.valid.eq(register(m, done, "done", control=True)),
            tokens.give.eq(self.friction.valid),
        ]
        return m

    def _divide(
        self, m: Module, divider: Divider, done: Value, start: Value, size: Value, normal: Value, negative: Value
    ) -> tuple[Value, Value]:
        """``size / normal`` as a scalar, limited to the longest one, and whether it is; zero for no force.

        The quotient waits in its divider until all are ``done``.
        """
        denominator = Cat(Const(0, 2), normal)
        vanishing, unbounded = (Signal(name=name, reset_less=True) for name in ("vanishing", "unbounded"))
        with m.If(start):
            m.d.sync += vanishing.eq(~size.any())
            m.d.sync += unbounded.eq((size >= denominator) & size.any())
        m.d.comb += [
            divider.i.valid.eq(start),
            divider.i.p.numerator.eq(size),
            divider.i.p.denominator.eq(denominator),
            divider.i.p.negative.eq(negative),
            divider.o.ready.eq(done),
        ]
        quotient, top = divider.o.payload, (1 << self._fraction) - 1
        limit = Mux(negative, -top, top)
        over = unbounded | (quotient > top) | (quotient < -top)
        return Mux(vanishing, 0, Mux(over, limit, quotient)), unbounded

    def _normal(self, m: Module, size: Value) -> Value:
        """|F_z| times the CORDIC gain, when the modulus comes."""
        first, _ = gain_constants(self._design)
        digits = first.bit_length()
        assert digits < cordic_latency(self._design)
        start = self.force.valid
        busy = busy_after(m, start, digits)
        product = serial_product(m, size, first, digits, start, busy, "normal")
        return product[iterations(self._design) - 2 :]
