"""UART transmitter: bytes to a line, 8 data bits, no parity, one stop bit."""

from typing import Any

from amaranth import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.uart.rx import BYTE


class Tx(wiring.Component):
    """Send bytes, ``divisor`` clock cycles a bit; a byte takes ``interval`` cycles."""

    def __init__(self, divisor: int) -> None:
        self._divisor = divisor
        super().__init__({
            "i": In(stream.Signature(BYTE)),
            "line": Out(1),  # the pin, from a register, high at rest
        })

    @property
    def interval(self) -> int:
        """Cycles from byte to byte: ten bits, and one in which the next is taken."""
        return 10 * self._divisor + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        left = Signal(range(self._divisor), reset_less=True)
        # Inverted, since registers are 0 at power-up and a line at rest is 1.  The stop bit is the last that is not 0.
        bits = Signal(BYTE + 2)
        low = Signal()
        count = Signal(range(BYTE + 2))
        busy = Signal()
        m.d.comb += [self.i.ready.eq(~busy), self.line.eq(~low), low.eq(bits[0])]
        m.d.sync += left.eq(left - 1)
        with m.If(~busy):
            m.d.sync += [
                left.eq(self._divisor - 1),
                count.eq(BYTE + 1),
                busy.eq(self.i.valid),
            ]
            with m.If(self.i.valid):
                m.d.sync += bits.eq(Cat(Const(1, 1), ~self.i.payload))
        with m.Elif(left == 0):
            m.d.sync += [
                left.eq(self._divisor - 1),
                bits.eq(bits >> 1),
                count.eq(count - 1),
                busy.eq(count != 0),
            ]
        return m
