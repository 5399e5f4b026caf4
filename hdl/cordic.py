"""CORDIC in vectoring mode: bit-exact hardware of :mod:`tfra.model.fixed.cordic`."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Shape, Signal, signed, unsigned
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


def cordic_vector(design: Design) -> data.StructLayout:
    """What is turned."""
    return data.StructLayout({"x": cordic_word(design), "y": cordic_word(design)})


def cordic_latency(design: Design) -> int:
    """Cycles from the transfer of a vector to that of its modulus and angle: one to enter, two for each rotation."""
    return 2 * iterations(design) + 1


class Cordic(wiring.Component):
    """Turn vectors onto the x axis: modulus times the CORDIC gain, and angle in ``2^-operand`` turns.

    ::

        left half plane: (x, y, angle) <- (-x, -y, 1/2 turn)
        i = 0, 1, ...:   (x, y, angle) <- (x + s (y >> i), y - s (x >> i), angle + s atan 2^-i),  s = sign of y

        vector -> place 0 -> shift -> place 1 -> add -> place 0, or turned

    A rotation takes two cycles, one to shift and one to add, since both in one would be the longest path of the core.
    So there are places for two vectors, one behind the other.  The rounding of the angle is added before the first
    rotation, so nothing follows the last.
    Resources: three adders and two barrel shifters, no multiplier.

    Members:
        vector: stream in of ``x``, ``y``; waits while its place is taken.
        urgent: in, the vector goes first: it does not wait, and throws out what is in its place.
        lost: out, that happens in this cycle.
        turned: stream out of ``modulus``, ``angle``, ``urgent``, ``latency`` cycles after the vector; ``ready`` is not
            looked at.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        turned = {"modulus": cordic_modulus(design), "angle": unsigned(design.formats.operand), "urgent": 1}
        super().__init__(
            {
                "vector": In(stream.Signature(cordic_vector(design))),
                "urgent": In(1),
                "lost": Out(1),
                "turned": Out(stream.Signature(data.StructLayout(turned))),
            }
        )

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a vector to that of its modulus and angle."""
        return cordic_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        steps, word = angle_table(self._design), cordic_word(self._design).width + GROWTH
        rotation = {"angle": self._design.formats.operand + ANGLE_GUARD, "rotation": count(len(steps) - 1), "urgent": 1}
        shape = data.StructLayout({"x": signed(word), "y": signed(word), **rotation})
        places = [Signal(shape, name=f"place{number}", reset_less=True) for number in range(2)]
        taken, last, enter = Signal(2), Signal(reset_less=True), Signal()
        m.d.comb += [
            self.vector.ready.eq(~taken[1] | self.urgent),
            enter.eq(self.vector.valid & self.vector.ready),
            self.lost.eq(taken[1] & enter),
            self.turned.p.modulus.eq(places[0].x),
            self.turned.p.angle.eq(places[0].angle[ANGLE_GUARD:]),
            self.turned.p.urgent.eq(places[0].urgent),
        ]
        m.d.sync += [
            taken.eq(Cat(enter | (taken[1] & ~last), taken[0])),
            self.turned.valid.eq(taken[1] & last & ~enter),
            last.eq(places[0].rotation == len(steps) - 1),
            places[1].eq(places[0]),
        ]
        self._add(m, *places)
        with m.If(enter):
            self._enter(m, places[0])
        return m

    def _add(self, m: Module, before: Any, after: Any) -> None:
        """``before`` is shifted on its way to ``after``, which is added to itself on its way back."""
        x, y = (Signal.like(before.x, name=f"{name}_shifted", reset_less=True) for name in "xy")
        step = Signal.like(before.angle, name="step", reset_less=True)
        table, up = angle_table(self._design), after.y[-1]
        table += [0] * ((1 << len(before.rotation)) - len(table))  # all of them, so that nothing is compared
        steps = Array(Const(value, len(step)) for value in table)
        m.d.sync += [
            x.eq(before.x >> before.rotation),
            y.eq(before.y >> before.rotation),
            step.eq(steps[before.rotation]),
            before.x.eq(add_or_subtract(after.x, y, up)),
            before.y.eq(add_or_subtract(after.y, x, ~up)),
            before.angle.eq(add_or_subtract(after.angle, step, up)),
            before.rotation.eq(after.rotation + 1),
            before.urgent.eq(after.urgent),
        ]

    def _enter(self, m: Module, place: Any) -> None:
        """Into the right half plane, with half a unit of the angle."""
        left, turn, half = self.vector.p.x[-1], 1 << len(place.angle), 1 << (ANGLE_GUARD - 1)
        m.d.sync += [
            place.x.eq(add_or_subtract(Const(0), self.vector.p.x, left)),
            place.y.eq(add_or_subtract(Const(0), self.vector.p.y, left)),
            place.angle.eq(Mux(left, turn // 2 + half, half)),
            place.rotation.eq(0),
            place.urgent.eq(self.urgent),
        ]
