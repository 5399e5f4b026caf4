"""CORDIC in vectoring mode: bit-exact hardware of :mod:`tfra.model.fixed.cordic`."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Const, Module, Mux, Shape, Signal, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import add_or_subtract, count
from tfra.model.design import Design
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, iterations
from tfra.model.fixed.widths import widths

ENTRY_GUARD = 2
"""Bits beyond a word of a division: for |word| times the gain of an earlier run and sqrt(2), which is below 4."""

GROWTH = 2
"""Bits that a run adds: sqrt(2) times the CORDIC gain is 2.33, and roundings add less than a unit each."""


def cordic_word(design: Design) -> Shape:
    """A coordinate at the entry: a word of a division, its negation, or the modulus of two of them."""
    return signed(widths(design).division + ENTRY_GUARD)


def cordic_modulus(design: Design) -> Shape:
    """The modulus at the exit; it is never negative."""
    return unsigned(cordic_word(design).width + GROWTH - 1)


class Cordic(wiring.Component):
    """Turn a vector onto the x axis: modulus times the CORDIC gain, and angle in ``2^-operand`` turns.

    ::

        left half plane: (x, y, angle) <- (-x, -y, 1/2 turn)
        i = 0, 1, ...:   (x, y, angle) <- (x + s (y >> i), y - s (x >> i), angle + s atan 2^-i),  s = sign of y

    One rotation per cycle; the rounding of the angle is added before the first of them, so nothing follows the
    last.  ``latency`` cycles from the transfer of ``i`` to that of ``o``; one vector every ``latency`` + 1 cycles.
    Resources: three adders and two barrel shifters, no multiplier.

    Members: ``i``: stream in of ``x``, ``y``; ``o``: stream out of ``modulus``, ``angle``.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        word = cordic_word(design)
        into = data.StructLayout({"x": word, "y": word})
        out = data.StructLayout({"modulus": cordic_modulus(design), "angle": unsigned(design.formats.operand)})
        super().__init__({"i": In(stream.Signature(into)), "o": Out(stream.Signature(out))})

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a vector to that of its modulus and angle."""
        return iterations(self._design) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        last = iterations(self._design) - 1
        turn, word = self._design.formats.operand + ANGLE_GUARD, cordic_word(self._design).width + GROWTH
        x, y = (Signal(signed(word), name=name, reset_less=True) for name in "xy")
        angle, rotation = Signal(turn, reset_less=True), Signal(count(last), reset_less=True)
        busy, done, above = Signal(), Signal(), Signal()
        steps = Array(Const(step, turn) for step in angle_table(self._design))

        m.d.comb += [
            above.eq(~y[-1]),
            self.i.ready.eq(~busy & ~done),
            self.o.valid.eq(done),
            self.o.p.modulus.eq(x),
            self.o.p.angle.eq(angle[ANGLE_GUARD:]),
        ]
        with m.If(busy):
            m.d.sync += [
                x.eq(add_or_subtract(x, y >> rotation, y[-1])),
                y.eq(add_or_subtract(y, x >> rotation, above)),
                angle.eq(add_or_subtract(angle, steps[rotation], y[-1])),
                rotation.eq(rotation + 1),
            ]
            with m.If(rotation == last):
                m.d.sync += [busy.eq(0), done.eq(1)]
        with m.Elif(done):
            m.d.sync += done.eq(~self.o.ready)
        with m.Elif(self.i.valid):
            left, half = self.i.p.x[-1], 1 << (ANGLE_GUARD - 1)
            m.d.sync += [
                x.eq(add_or_subtract(Const(0), self.i.p.x, left)),
                y.eq(add_or_subtract(Const(0), self.i.p.y, left)),
                angle.eq(Mux(left, (1 << (turn - 1)) + half, half)),
                rotation.eq(0),
                busy.eq(1),
            ]
        return m
