"""Arithmetic of one instruction; all combinational, bit-exact to :mod:`tfra.hdl.serial.program.interpreter`."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import saturate
from tfra.hdl.serial.isa import Op
from tfra.hdl.serial.sizes import Sizes

ADDS = (Op.ADD, Op.SUB, Op.PLUS, Op.LESS, Op.ABS, Op.FIT, Op.DIV)
"""Operations whose result is a sum."""

FINE = 4
"""Low bits of a shift's amount: the ALU shifts by them, :func:`coarse` by the others before."""


class Alu(wiring.Component):
    """The result of ``op``: a sum if the operation ``adds``, otherwise a function of ``left`` and ``source``.

    The sum is the critical path, so only one 4-input table follows it for ``result``, and none for ``total``.
    """

    def __init__(self, sizes: Sizes) -> None:
        self._sizes = sizes
        word = signed(sizes.word)
        super().__init__({
            "op": In(Op),  # the operation
            "adds": In(1),  # the operation is one of ``ADDS``
            "left": In(word),  # the first operand
            "source": In(word),  # the second operand
            # the second operand as the sum takes it: complemented to subtract, zero where it is dropped
            "addend": In(word),
            "carry": In(1),  # carry into the sum: to subtract, or to round
            # what :func:`coarse` made of the source
            "coarse": In(sizes.word + (1 << FINE)),
            "fine": In(FINE),  # the rest of the shift's amount
            "total": Out(word),  # left + addend + carry
            "result": Out(word),  # the result of ``op``
            "shifted": Out(signed(sizes.word + 1)),  # the T of SHIFT and LENGTH
            "limited": Out(1),  # LIMIT changes its source
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        op, source, word, result = self.op, self.source, self._sizes.word, self._sizes.result
        beyond = source[result - 1 :]  # all alike in words that LIMIT leaves as they are
        bit_length = Cat(source.any(), _highest(source.as_unsigned()), Const(0, 1))  # with the bit below the point
        barrel = (self.coarse >> self.fine)[: word + 1]
        m.d.comb += [
            self.total.eq(_sum(self.left, self.addend, self.carry)),
            self.limited.eq(beyond.any() & ~beyond.all()),
            self.shifted.eq(Mux(op == Op.LENGTH, bit_length, barrel)),
        ]
        other = Signal(signed(word))
        with m.Switch(op):
            with m.Case(Op.OR):
                m.d.comb += other.eq(self.left | (source ^ source[-1].replicate(word).as_signed()))
            with m.Case(Op.AND):
                m.d.comb += other.eq(self.left & source)
            with m.Case(Op.LIMIT):
                m.d.comb += other.eq(saturate(source, result))
            with m.Case(Op.LENGTH):
                m.d.comb += other.eq(bit_length[1:])
            with m.Default():
                m.d.comb += other.eq(barrel[1:].as_signed())
        m.d.comb += self.result.eq(Mux(self.adds, self._fitted(m), other))
        return m

    def _fitted(self, m: Module) -> Value:
        """``total``; for FIT the largest operand where rounding has made it one bit too long."""
        total, word, operand = self.total, self._sizes.word, self._sizes.operand
        too_long = Signal()
        m.d.comb += too_long.eq((self.op == Op.FIT) & total[operand - 1] & ~self.left[-1])
        low = total[: operand - 1] | too_long.replicate(operand - 1)
        high = total[operand - 1 :] & ~too_long.replicate(word - operand + 1)
        return Cat(low, high)


def coarse(sizes: Sizes, source: Value, amount: Value) -> Value:
    """``source``, with a bit below the point, shifted right by the high bits of ``amount``, which is SH + reach."""
    high = Cat(Const(0, FINE), amount[FINE:])
    return (Cat(Const(0, sizes.reach + 1), source).as_signed() >> high)[: sizes.word + (1 << FINE)]


def signs(op: Any, negative: Value) -> tuple[Value, Value]:
    """Whether ``op`` subtracts, and whether it drops its source, whose sign is ``negative``."""
    subtract = (op == Op.SUB) | (op == Op.LESS) | (op == Op.DIV) | ((op == Op.ABS) & negative)
    return subtract, ((op == Op.PLUS) & negative) | ((op == Op.LESS) & ~negative)


def _sum(a: Value, b: Value, carry: Value) -> Value:
    """a + b + carry as a carry-select adder: the upper half is computed for both carries of the lower half."""
    half = len(a) // 2
    low = Cat(Const(1, 1), a[:half]) + Cat(carry, b[:half])
    with_carry, without = (Cat(Const(1, 1), a[half:]) + Cat(Const(c, 1), b[half:]) for c in (1, 0))
    return Cat(low[1 : half + 1], Mux(low[half + 1], with_carry[1 : len(a) - half + 1], without[1 : len(a) - half + 1]))


def _highest(value: Value) -> Value:
    """Number of the highest set bit of an unsigned value, zero for zero: a tree of multiplexers."""
    if len(value) == 1:
        return Const(0, 1)
    half = 1 << ((len(value) - 1).bit_length() - 1)
    low, high = value[:half], value[half:]
    bits = (half - 1).bit_length()
    return Cat(Mux(high.any(), _highest(high), _highest(low))[:bits], high.any()) if bits else high
