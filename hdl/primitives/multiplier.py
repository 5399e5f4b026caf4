"""Signed multiplier with registers on both sides."""

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.primitives.gateware import GATEWARE


class Multiplier(wiring.Component):
    """``product = a * b``, exact, :attr:`latency` enabled cycles later, one a cycle.

    ======== ================================================================================================
    target   made of
    ======== ================================================================================================
    portable registers for ``a``, ``b`` and ``product``, none of them reset
    ice40    the same, which yosys packs into SB_MAC16
    ecp5     MULT18X18D with its input and output registers: one for factors up to 18 bits.  Longer factors are
             split into a low digit of 17 bits and the rest; the sum of the two or four products follows the
             output registers without another one.
    ======== ================================================================================================
    """

    latency = 2

    def __init__(self, a_bits: int, b_bits: int, target: str) -> None:
        self._cells = GATEWARE[target].multiplier
        super().__init__({
            "a": In(signed(a_bits)),  # 35 bits at most, as ``b``
            "b": In(signed(b_bits)),
            "enable": In(1, init=1),  # the registers hold while it is low
            "product": Out(signed(a_bits + b_bits)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._cells:
            m.d.comb += self.product.eq(self._cells(m, self.a, self.b, self.enable))
        else:
            self._registers(m)
        return m

    def _registers(self, m: Module) -> None:
        a = Signal.like(self.a, reset_less=True)
        b = Signal.like(self.b, reset_less=True)
        product = Signal.like(self.product, reset_less=True)
        m.d.comb += self.product.eq(product)
        with m.If(self.enable):
            m.d.sync += [a.eq(self.a), b.eq(self.b), product.eq(a * b)]
