"""The resultant and its plausibility: bit-exact hardware of :mod:`tfra.model.fixed.learned.resultant`."""

from functools import reduce
from operator import or_
from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, magnitude_bits, round_off, round_top, saturate, two_steps
from tfra.hdl.lib.pipeline import busy_after, delayed, driver, register, registered_zeros, serial_product
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.learned.payloads import judged
from tfra.model.fixed.butterfly import EE, OX, OY
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION

_FINE = 2
"""Bits of a shift by which its second step moves."""

_AXES = (("f_x", OX), ("f_y", OY), ("f_z", EE))
"""Words of F and their parities in the first quad."""

# Cycles after the transfer of a frame's first quad, and their registers.
_HELD = 1
"""F, and the OR of its magnitudes."""
_ZEROS = _HELD + 2
"""Zeros that all of F has after the signs; a part of them a cycle sooner."""
_WORDS = _ZEROS + 3
"""F moved coarsely, moved finely, rounded."""


class Resultant(wiring.Component):
    """F of the outputs, normalised for what follows, and as result words with the uncertainty.

    ::

        total -> F -+-> zeros of all three -> shift -> round -> force
                    +-> round to result words, saturate ------> judged
                    '-> |F_z| * threshold -> < u -------------> judged

    A frame at a time: ``judged`` stays until the outputs of the next.  The product with the threshold is serial.
    Resources: three barrel shifters, no multiplier.
    """

    latency = _WORDS
    """Cycles from the transfer of a frame's first quad to that of ``force``."""

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        self._digits = max(1, design.threshold_word.bit_length())
        self._shift = design.formats.vector_fraction - design.formats.force_fraction
        super().__init__({
            "total": In(always_ready_stream(payloads.vector_quad(design))),  # two quads a frame
            "force": Out(always_ready_stream(payloads.total(design))),  # one a frame; stays until the next
            "judged": Out(judged(design)),  # complete ``judged_latency`` cycles after the frame's second quad
        })

    @property
    def judged_latency(self) -> int:
        """Two registers before the serial product, one for each of its digits, and two after it."""
        return 2 + self._digits + 2

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        quads = self.total.payload
        second = Signal()
        m.d.sync += second.eq(second ^ self.total.valid)
        first_valid, second_valid = self.total.valid & ~second, self.total.valid & second
        f = [Signal(quads[parity].shape(), name=name, reset_less=True) for name, parity in _AXES]
        u = Signal(quads[EE].shape(), reset_less=True)
        with m.If(first_valid):
            m.d.sync += [word.eq(quads[parity]) for word, (_, parity) in zip(f, _AXES, strict=True)]
        with m.If(second_valid):
            m.d.sync += u.eq(Mux(quads[EE][-1], 0, quads[EE]))
        self._normalise(m, first_valid, f)
        self._judge(m, register(m, second_valid, "start", control=True), f, u)
        return m

    def _normalise(self, m: Module, valid: Value, f: list[Signal]) -> None:
        """F at division length; the zeros of the OR of its magnitudes are found before the shift."""
        width, bits = len(f[0]), self._design.widths.division
        words = [magnitude_bits(self.total.p[parity]) for _, parity in _AXES]
        magnitudes = register(m, reduce(or_, words), "magnitudes")
        zeros = Signal(counter_shape(width - 1), reset_less=True)
        common = registered_zeros(m, magnitudes)
        with m.If(delayed(m, valid, _ZEROS - 1, "measured", control=True)):
            m.d.sync += zeros.eq(common)
        coarse, _ = two_steps(zeros, _FINE)
        _, fine = two_steps(register(m, zeros, "fine"), _FINE)
        force = driver(m, self.force.payload)
        for axis, word in enumerate(f):
            moved = register(m, (word << coarse)[:width].as_signed(), f"moved{axis}")
            aligned = register(m, (moved << fine)[:width].as_signed(), f"aligned{axis}")
            m.d.sync += force.words[axis].eq(round_top(aligned, bits))
        m.d.sync += force.exponent.eq(delayed(m, zeros, _WORDS - _ZEROS - 1, "shifts") + (bits - width))
        m.d.comb += self.force.valid.eq(delayed(m, valid, _WORDS, "valid", control=True))

    def _judge(self, m: Module, start: Value, f: list[Signal], u: Signal) -> None:
        """Result words, and the verdict."""
        verdict = driver(m, self.judged)
        output = self._design.widths.output
        # TIMING: rounding -> limit
        longer = 1 if self._shift > 0 else -self._shift  # for the carry of a rounding, or for a finer grid
        wide = [Signal(signed(len(word) + longer), name="wide", reset_less=True) for word in (*f, u)]
        m.d.sync += [into.eq(self._on_result_grid(word)) for into, word in zip(wide, (*f, u), strict=True)]
        beyond = [register(m, ~(word[output - 1 :] == 0) & ~word[output - 1 :].all(), "beyond") for word in wide]
        f_z = f[-1]
        size = register(m, abs(f_z), "size")
        busy = busy_after(m, start, self._digits)
        product = serial_product(m, size, self._design.threshold_word, self._digits, start, busy, "allowed")
        doubtful = register(m, Cat(Const(0, THRESHOLD_FRACTION), u[:-1]) > product, "doubtful")
        m.d.sync += [
            *(
                into.eq(saturate(word, output))
                for into, word in zip((*verdict.words, verdict.uncertainty), wide, strict=True)
            ),
            verdict.limited.eq(Cat(beyond).any()),
            verdict.implausible.eq(doubtful | ~f_z[-1]),
        ]

    def _on_result_grid(self, word: Value) -> Value:
        """A word on the vector grid rounded to that of result words."""
        if self._shift <= 0:
            return (word << -self._shift).as_signed()
        return round_off(word, self._shift)
