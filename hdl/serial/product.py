"""A signed product in the multiplier blocks of a small FPGA: 16 by 16 bits."""

from functools import reduce
from operator import add
from typing import Any

from amaranth import Const, Module, Mux, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

DELAY = 2
"""Cycles from the operands to their product: registers of partial products, and of the sum."""

_BLOCK, _SLICE, _LOGIC = 16, 15, 3
"""Bits of a signed block's operand, of each further slice, and as many as logic multiplies for less than a block."""


def low_bits(bits: int) -> int:
    """Low bits of a word that logic multiplies, so that blocks hold the rest."""
    rest = (bits - _BLOCK) % _SLICE
    return rest if bits > _BLOCK and rest <= _LOGIC else 0


class Product(wiring.Component):
    """``o = a * b``, ``DELAY`` cycles later."""

    def __init__(self, a_bits: int, b_bits: int, bits: int) -> None:
        super().__init__({
            "a": In(signed(a_bits)),
            "b": In(signed(b_bits)),
            "start": In(1, init=1),  # take the operands; without it the last ones are kept
            "enable": In(1, init=1),  # stops all registers while it is low
            "o": Out(signed(bits)),  # registered; a longer product wraps
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        a, b = self.a, self.b
        a_low, b_low = low_bits(len(a)), low_bits(len(b))
        a_high, b_high = a[a_low:].as_signed(), b[b_low:].as_signed()
        blocks = Signal(signed(len(a_high) + len(b_high)), reset_less=True)
        logic = Signal(signed(len(a) + len(b)), reset_less=True)
        with m.If(self.enable & self.start):
            m.d.sync += [
                blocks.eq(a_high * b_high),
                logic.eq(_by_additions(b, a[:a_low]) + (_by_additions(a_high, b[:b_low]) << a_low)),
            ]
        with m.If(self.enable):
            m.d.sync += self.o.eq((blocks << (a_low + b_low)) + logic if a_low + b_low else blocks)
        return m


def _by_additions(word: Value, bits: Value) -> Value:
    """``word`` times a few unsigned ``bits``."""
    parts = [Mux(bit, word, 0).as_signed() << place for place, bit in enumerate(bits)]
    return reduce(add, parts) if parts else Const(0)
