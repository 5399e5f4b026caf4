"""A signed product in the multiplier blocks a small FPGA has: 16 by 16 bits."""

from __future__ import annotations

from functools import reduce
from operator import add
from typing import Any

from amaranth import Const, Elaboratable, Module, Mux, Signal, Value, signed

DELAY = 2
"""Cycles from the operands to their product: registers of partial products, and of the sum."""

_BLOCK, _SLICE, _LOGIC = 16, 15, 3


def low_bits(bits: int) -> int:
    """Bits of a word that logic multiplies, so that the rest fills blocks: a signed block has 16 bits, others 15."""
    rest = (bits - _BLOCK) % _SLICE
    return rest if bits > _BLOCK and rest <= _LOGIC else 0


class Product(Elaboratable):
    """``o`` = ``a`` * ``b`` of the last ``start``, ``DELAY`` cycles later; ``o`` wraps to its ``bits``.

    ``enable`` stops all of it.
    """

    def __init__(self, a_bits: int, b_bits: int, bits: int) -> None:
        self.a, self.b, self.o = (Signal(signed(n)) for n in (a_bits, b_bits, bits))
        self.start, self.enable = Signal(init=1), Signal(init=1)

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
                logic.eq(_few(b, a[:a_low]) + (_few(a_high, b[:b_low]) << a_low)),
            ]
        with m.If(self.enable):
            m.d.sync += self.o.eq((blocks << (a_low + b_low)) + logic if a_low + b_low else blocks)
        return m


def _few(word: Value, bits: Value) -> Value:
    """``word`` times a few unsigned ``bits``, by additions."""
    parts = [Mux(bit, word, 0).as_signed() << place for place, bit in enumerate(bits)]
    return reduce(add, parts) if parts else Const(0)
