"""Arithmetic of one instruction; all combinational, bit-exact to :mod:`tfra.hdl.serial.program.interpreter`."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Elaboratable, Module, Mux, Signal, signed

from tfra.hdl.lib.arithmetic import saturate
from tfra.hdl.serial.isa import Op
from tfra.hdl.serial.sizes import Sizes


class Alu(Elaboratable):
    """``result`` of ``op``: ``left`` + ``addend`` + ``carry`` if ``adds``, else made of ``left`` and ``source``.

    ``shifted`` is the T of SHIFT and LENGTH, ``limited`` says that LIMIT did.  A shift has two halves: ``coarse`` is
    what :func:`coarse` made of the source, ``fine`` what of the amount is left.
    The sum takes the longest, so only one table of four inputs stands behind it, and none in ``total``.
    """

    def __init__(self, sizes: Sizes) -> None:
        self._sizes = sizes
        self.op, self.adds = Signal(Op), Signal()
        self.left, self.source, self.addend, self.total, self.result = (Signal(signed(sizes.word)) for _ in range(5))
        self.carry, self.limited = Signal(), Signal()
        self.coarse, self.fine = Signal(sizes.word + (1 << FINE)), Signal(FINE)
        self.shifted = Signal(signed(sizes.word + 1))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        op, s, word, operand, result = self.op, self.source, self._sizes.word, self._sizes.operand, self._sizes.result
        total, other = self.total, Signal(signed(word))
        above, too_long = s[result - 1 :], Signal()
        length = Cat(s.any(), _highest(s.as_unsigned()), Const(0, 1))
        barrel = (self.coarse >> self.fine)[: word + 1]
        m.d.comb += [
            total.eq(_sum(self.left, self.addend, self.carry)),
            too_long.eq((op == Op.FIT) & total[operand - 1] & ~self.left[-1]),
            self.limited.eq(above.any() & ~above.all()),
            self.shifted.eq(Mux(op == Op.LENGTH, length, barrel)),
        ]
        with m.Switch(op):
            with m.Case(Op.OR):
                m.d.comb += other.eq(self.left | (s ^ s[-1].replicate(word).as_signed()))
            with m.Case(Op.AND):
                m.d.comb += other.eq(self.left & s)
            with m.Case(Op.LIMIT):
                m.d.comb += other.eq(saturate(s, result))
            with m.Case(Op.LENGTH):
                m.d.comb += other.eq(length[1:])
            with m.Default():
                m.d.comb += other.eq(barrel[1:].as_signed())
        low = total[: operand - 1] | too_long.replicate(operand - 1)
        high = total[operand - 1 :] & ~too_long.replicate(word - operand + 1)
        m.d.comb += self.result.eq(Mux(self.adds, Cat(low, high), other))
        return m


FINE = 4
"""Bits of a shift's amount that the ALU takes care of."""


def coarse(sizes: Sizes, source: Any, amount: Any) -> Any:
    """``source``, with a bit below the point, shifted right by the high bits of ``amount``, which is SH + reach."""
    high = Cat(Const(0, FINE), amount[FINE:])
    return (Cat(Const(0, sizes.reach + 1), source).as_signed() >> high)[: sizes.word + (1 << FINE)]


ADDS = (Op.ADD, Op.SUB, Op.PLUS, Op.LESS, Op.ABS, Op.FIT, Op.DIV)
"""Operations whose result is a sum."""


def _sum(a: Any, b: Any, carry: Any) -> Any:
    """a + b + carry; the upper half is there for either carry of the lower one, which then chooses: half the wait."""
    half = len(a) // 2
    low = Cat(Const(1, 1), a[:half]) + Cat(carry, b[:half])
    with_carry, without = (Cat(Const(1, 1), a[half:]) + Cat(Const(c, 1), b[half:]) for c in (1, 0))
    return Cat(low[1 : half + 1], Mux(low[half + 1], with_carry[1 : len(a) - half + 1], without[1 : len(a) - half + 1]))


def _highest(value: Any) -> Any:
    """Number of the highest set bit of an unsigned value, zero for zero: multiplexers alone."""
    if len(value) == 1:
        return Const(0, 1)
    half = 1 << ((len(value) - 1).bit_length() - 1)
    low, high = value[:half], value[half:]
    bits = (half - 1).bit_length()
    return Cat(Mux(high.any(), _highest(high), _highest(low))[:bits], high.any()) if bits else high


def signs(op: Any, negative: Any) -> tuple[Any, Any]:
    """Whether ``op`` subtracts, and whether it drops its source, whose sign is ``negative``."""
    subtract = (op == Op.SUB) | (op == Op.LESS) | (op == Op.DIV) | ((op == Op.ABS) & negative)
    return subtract, ((op == Op.PLUS) & negative) | ((op == Op.LESS) & ~negative)
