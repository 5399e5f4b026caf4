"""CORDIC in vectoring mode: bit-exact hardware of :mod:`tfra.model.fixed.cordic`."""

from typing import Any

from amaranth import Array, Const, Module, Mux, Shape, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import add_or_subtract, counter_shape
from tfra.hdl.lib.pipeline import delayed, register
from tfra.hdl.lib.streams import always_ready_stream
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, iterations
from tfra.model.fixed.design import Design
from tfra.model.rounding import Rounding

ENTRY_GUARD = 2
"""Bits beyond a word of a division: for |word| times the gain of an earlier run and sqrt(2), which is below 4."""

GROWTH = 2
"""Bits that a run adds: sqrt(2) times the CORDIC gain is 2.33, and roundings add less than a unit each."""


def cordic_word(design: Design) -> Shape:
    """A coordinate at the entry: a word of a division, its negation, or the modulus of two of them."""
    return signed(design.widths.division + ENTRY_GUARD)


def cordic_modulus(design: Design) -> Shape:
    """The modulus at the exit; it is never negative."""
    return unsigned(cordic_word(design).width + GROWTH - 1)


def cordic_vector(design: Design) -> data.StructLayout:
    """The vector to be rotated."""
    return data.StructLayout({"x": cordic_word(design), "y": cordic_word(design)})


def cordic_latency(design: Design) -> int:
    """Cycles from the transfer of a vector to that of its modulus: one to enter, one for each rotation."""
    return iterations(design) + 1


class Cordic(wiring.Component):
    """Rotate vectors onto the x axis: modulus times the CORDIC gain, and the signs of the rotations.

    ::

        left half plane: (x, y) <- (-x, -y)
        i = 0, 1, ...:   (x, y) <- (x + s (y >> i), y - s (x >> i)),  s = sign of y

    A pipeline with a register after the entry and after each rotation: one vector a cycle, without backpressure.

    y gets a bit shorter with each rotation.  Rotation 0 makes |y| <= x, and x never falls.  If |y| <= x 2^(1-i) + e
    before rotation i, then |y| <= x 2^-i + e + 1 after it, since the shift of x rounds by less than a unit.  So |y| is
    below 2^(bits-i) + i before rotation i, where ``bits`` is the length of x.
    Resources: two adders for each rotation, no multiplier.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "vector": In(always_ready_stream(cordic_vector(design))),  # ``x``, ``y``
            # The modulus, ``cordic_latency`` cycles after the vector.
            "turned": Out(always_ready_stream(cordic_modulus(design))),
            # Bit i: the vector that came i + 1 cycles ago is turned upwards by rotation i.
            "negative": Out(iterations(design)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits, vector = cordic_word(self._design).width + GROWTH, self.vector.p
        left = vector.x[-1]
        x, y = (self._word(m, add_or_subtract(Const(0), vector[n], left), bits, f"{n}0") for n in "xy")
        for number in range(iterations(self._design)):
            up = y[-1]
            m.d.comb += self.negative[number].eq(up)
            x, y = (
                self._word(m, add_or_subtract(x, y >> number, up), bits, f"x{number + 1}"),
                self._word(m, add_or_subtract(y, x >> number, ~up), self._y_bits(number + 1), f"y{number + 1}"),
            )
        m.d.comb += [
            self.turned.payload.eq(x),
            self.turned.valid.eq(delayed(m, self.vector.valid, cordic_latency(self._design), "valid", control=True)),
        ]
        return m

    def _y_bits(self, number: int) -> int:
        """Length of y before rotation ``number``."""
        bits: int = cordic_word(self._design).width + GROWTH
        assert number <= 1 << (bits - number)
        return min(bits, bits - number + 2)

    @staticmethod
    def _word(m: Module, value: Value, bits: int, name: str) -> Signal:
        """``value`` in a register of ``bits``, which it fits."""
        word = Signal(signed(bits), name=name, reset_less=True)
        m.d.sync += word.eq(value)
        return word


def summed_angle(m: Module, design: Design, enter: Value, marks: Value, negative: Value, left: Value) -> Signal:
    """The angle: half a turn for a vector of the left half plane, and the turn of each rotation, a cycle late.

    ``rotation`` is the one whose turn is looked up: the next one of the direction.
    """
    table, half = angle_table(design), Rounding.HALF_UP.constant(ANGLE_GUARD)
    angle = Signal(iterations(design) + ANGLE_GUARD, name="angle_so_far", reset_less=True)
    rotation = Signal(counter_shape(len(table)), reset_less=True)
    table += [0] * ((1 << len(rotation)) - len(table))  # all of them, so that nothing is compared
    step = register(m, Array(Const(value, len(angle)) for value in table)[rotation], "step")
    up = register(m, (marks & negative).any(), "up")
    going = register(m, marks.any(), "going", control=True)
    m.d.sync += rotation.eq(Mux(enter, 0, rotation + 1))
    with m.If(marks[0]):
        m.d.sync += angle.eq(Mux(left, (1 << (len(angle) - 1)) + half, half))
    with m.Elif(going):
        m.d.sync += angle.eq(add_or_subtract(angle, step, up))
    return angle
