"""CORDIC in vectoring mode: bit-exact hardware of :mod:`tfra.model.fixed.cordic`."""

from __future__ import annotations

from typing import Any

from amaranth import Const, Module, Mux, Shape, Signal, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import add_or_subtract
from tfra.hdl.pipeline import register
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


def cordic_vector(design: Design) -> data.StructLayout:
    """What enters."""
    return data.StructLayout({"x": cordic_word(design), "y": cordic_word(design)})


def cordic_latency(design: Design) -> int:
    """Cycles from the transfer of a vector to that of its modulus and angle: one to enter, one for each rotation."""
    return iterations(design) + 1


class Cordic(wiring.Component):
    """Turn a vector onto the x axis: modulus times the CORDIC gain, and angle in ``2^-operand`` turns.

    ::

        left half plane: (x, y, angle) <- (-x, -y, 1/2 turn)
        i = 0, 1, ...:   (x, y, angle) <- (x + s (y >> i), y - s (x >> i), angle + s atan 2^-i),  s = sign of y

    A register behind every rotation, so that shifts are wiring; the rounding of the angle is added before the first of
    them, so nothing follows the last.  One vector per cycle, ``latency`` cycles from the transfer of ``i`` to that of
    ``o``; all wait together for ``o``.  Resources: three adders a rotation, no multiplier.

    y loses a bit with every rotation: ``|y| <= 2 x / 2^i + i`` holds from the first one on, since y then is either what
    ``x >> i`` leaves of it or less than that.

    Members: ``i``: stream in of ``x``, ``y``; ``o``: stream out of ``modulus``, ``angle``.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        out = data.StructLayout({"modulus": cordic_modulus(design), "angle": unsigned(design.formats.operand)})
        super().__init__({"i": In(stream.Signature(cordic_vector(design))), "o": Out(stream.Signature(out))})

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a vector to that of its modulus and angle."""
        return cordic_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        turn, word = self._design.formats.operand + ANGLE_GUARD, cordic_word(self._design).width + GROWTH
        left, half, move = self.i.p.x[-1], 1 << (ANGLE_GUARD - 1), Signal()
        m.d.comb += [move.eq(~self.o.valid | self.o.ready), self.i.ready.eq(move)]
        with m.If(move):
            x = register(m, add_or_subtract(Const(0), self.i.p.x, left)[:word].as_signed(), "x")
            y = register(m, add_or_subtract(Const(0), self.i.p.y, left)[:word].as_signed(), "y")
            angle = register(m, Mux(left, (1 << (turn - 1)) + half, half), "angle")
            valid = register(m, self.i.valid, "valid", control=True)
            for i, step in enumerate(angle_table(self._design)):
                up, bits = y[-1], min(word, word - i + 1)
                x, y, angle = (
                    register(m, add_or_subtract(x, y >> i, up)[:word].as_signed(), "x"),
                    register(m, add_or_subtract(y, x >> i, ~up)[:bits].as_signed(), "y"),
                    register(m, add_or_subtract(angle, Const(step, turn), up)[:turn], "angle"),
                )
                valid = register(m, valid, "valid", control=True)
        m.d.comb += [
            self.o.valid.eq(valid),
            self.o.p.modulus.eq(x),
            self.o.p.angle.eq(angle[ANGLE_GUARD:]),
        ]
        return m
