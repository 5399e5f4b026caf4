"""``z + s * x``: W multipliers between two shifts, and an adder that rounds."""

from enum import IntEnum
from typing import Any

from amaranth import C, Cat, Module, Signal, Value, signed
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, round_top, two_steps
from tfra.hdl.lib.pipeline import READ, register
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.rounding import Rounding


class Stage(IntEnum):
    """Cycles from a beat's entry, by what the registers of the two operands of ``z + s * x`` hold then.

    ::

        s * x:  ENTRY   X_ADDRESS   X_CELL   X_READ   X_CHOSEN   COARSE   ALIGNED   ROUNDED
                OPERAND     PRODUCT   CUT      COARSE_BACK   SHIFTED                 SUM   OUTPUT
        z:      Z_ADDRESS   Z_CELL    Z_READ   Z_CHOSEN      Z                       SUM   OUTPUT

    z is read as late as its product allows, to reach the adder in the same cycle.
    """

    ENTRY = 0
    X_ADDRESS = 1
    X_CELL = 2
    X_READ = X_ADDRESS + READ
    X_CHOSEN = 4
    COARSE = 5
    ALIGNED = 6
    ROUNDED = 7
    OPERAND = 8
    PRODUCT = 9
    CUT = 10
    COARSE_BACK = 11
    SHIFTED = 12
    SUM = 13
    OUTPUT = 14

    Z = SHIFTED
    Z_CHOSEN = Z - 1
    Z_READ = Z_CHOSEN - 1
    Z_CELL = Z_READ - 1
    Z_ADDRESS = Z_READ - READ


def staged(m: Module, value: Any, first: Stage, last: Stage, name: str, *, control: bool = False) -> dict[Stage, Any]:
    """``value`` of a beat in stage ``first``, delayed with that beat through every stage up to ``last``."""
    by_stage = {first: value}
    for stage in (Stage(number) for number in range(first + 1, last + 1)):
        value = by_stage[stage] = register(m, value, f"{name}_{stage.name.lower()}", control=control)
    return by_stage


_FINE = 2
"""Bits of a headroom by which the second step of a shift moves: a word's whole shift would be a long path."""


def beat_headroom(bits: int, words: int) -> data.ArrayLayout:
    """For each of the ``words`` of a beat, of ``bits``, the headroom of its parity over the whole vector."""
    return data.ArrayLayout(counter_shape(bits - 1), words)


class ScaleAdd(wiring.Component):
    """A beat of ``z + round(s * x)``, where x is a multiplier operand: x is shifted left by its headroom and rounded.

    ::

        x -> coarse -> aligned -> rounded -> operand -> product -> cut -> coarse_back -> shifted -> sum
        s ---------------------------------> scalar -'                             z -----------'

    Each name is a register and a stage of :class:`Stage`.  x is shifted left by
    its headroom; the product is shifted right by the same amount.

    Arguments:
        words: of a beat.
        bits: of a word; those of a vector, or fewer where all words and the sum fit them.
    """

    def __init__(self, design: Design, words: int, bits: int) -> None:
        self._design, self._bits = design, bits
        beat = data.ArrayLayout(signed(bits), words)
        super().__init__({
            "x": In(beat),  # of the beat in stage ``X_CHOSEN``
            "headroom": In(beat_headroom(bits, words)),  # that of ``x``, beside it
            "scalar": In(signed(design.formats.bits("scalar"))),  # s of the beat in stage ``ROUNDED``
            "z": In(beat),  # of the beat in stage ``Z``
            "sum": Out(beat),  # of the beat in stage ``SUM``
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        headroom = staged(m, self.headroom, Stage.X_CHOSEN, Stage.COARSE_BACK, "headroom")
        scalar = Signal(self.scalar.shape(), reset_less=True)
        m.d.sync += scalar.eq(self.scalar)
        operands = self._operands(m, headroom)
        shifted = self._multiply(m, operands, scalar, headroom)
        total = Signal(self.sum.shape(), name="sum", reset_less=True)
        m.d.comb += self.sum.eq(total)
        below = C(Rounding.HALF_UP.constant(1), 1)
        for k in range(len(total)):
            # z + round_off(shifted, 1) in one adder: what rounds is added below z.
            m.d.sync += total[k].eq((Cat(below, self.z[k]).as_signed() + shifted[k]) >> 1)
        return m

    def _operands(self, m: Module, headroom: dict[Stage, Any]) -> Any:
        """x, shifted left by its headroom in two steps and rounded to multiplier operands."""
        bits = self._design.formats.bits("operand.combine")
        aligned = Signal(self.x.shape(), reset_less=True)
        operands = Signal(data.ArrayLayout(signed(bits), len(self.x)), reset_less=True)
        for k in range(len(self.x)):
            coarse_amount, _ = two_steps(headroom[Stage.X_CHOSEN][k], _FINE)
            _, fine_amount = two_steps(headroom[Stage.COARSE][k], _FINE)
            coarse = register(m, self.x[k] << coarse_amount, f"coarse{k}")
            m.d.sync += [
                aligned[k].eq(coarse << fine_amount),
                operands[k].eq(register(m, round_top(aligned[k], bits), f"rounded{k}")),
            ]
        return operands

    def _multiply(self, m: Module, operands: Any, scalar: Value, headroom: dict[Stage, Any]) -> Any:
        """Products on the grid of z with one bit below the point, shifted right by the headroom of x in two steps."""
        size, bits = len(operands), self._design.formats.bits("operand.combine")
        drop = scalar_fraction(self._design) + bits - self._bits
        # A register for each word: yosys packs one of all words into the SB_MAC16 of the first and loses the rest.
        product = [Signal(signed(bits + len(scalar)), name=f"product{k}", reset_less=True) for k in range(size)]
        shifted = Signal(data.ArrayLayout(signed(self._bits + 1), size), reset_less=True)
        for k in range(size):
            # TIMING: multiplier -> shift back
            # Of the bits that are read alone: yosys packs a register of all into an SB_MAC16 and loses it.
            cut = register(m, _drop(product[k], drop), f"cut{k}")
            coarse_amount, _ = two_steps(headroom[Stage.CUT][k], _FINE)
            _, fine_amount = two_steps(headroom[Stage.COARSE_BACK][k], _FINE)
            coarse_back = register(m, cut >> coarse_amount, f"coarse_back{k}")
            m.d.sync += [
                product[k].eq(operands[k] * scalar),
                shifted[k].eq(coarse_back >> fine_amount),
            ]
        return shifted


def _drop(product: Value, drop: int) -> Value:
    """``product / 2^drop`` with one bit below the point; what is left to shift is the headroom of x.

    The bits cut off can't reach the rounding; vectors longer than operands make ``drop`` negative.
    """
    return product[drop - 1 :].as_signed() if drop > 0 else Cat(C(0, 1 - drop), product).as_signed()
