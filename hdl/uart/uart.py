"""UART: bytes on a line, 8 data bits, no parity, one stop bit."""

from typing import Any

from amaranth import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.lib.streams import always_ready_stream

BYTE = 8


class Rx(wiring.Component):
    """Receive bytes of ``divisor`` clock cycles a bit; a bit is sampled in its middle."""

    def __init__(self, divisor: int) -> None:
        self._divisor = divisor
        super().__init__({
            "line": In(1),  # the pin, asynchronous, high at rest
            "o": Out(always_ready_stream(BYTE)),  # ``valid`` is high for one cycle
            "fault": Out(1),  # pulse: the stop bit was low, and the byte is lost
            "broken": Out(1),  # a break: the stop bit after eight zeros was low; until the line is high again
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        # Two registers for the clock's domain; inverted, since registers are 0 at power-up and a line at rest is 1.
        line = ~delayed(m, ~self.line, 2, "line", control=True)
        left = Signal(range(self._divisor), reset_less=True)
        # A 1 above the bits to come; it is in the lowest place when the stop bit is next.
        bits = Signal(BYTE + 1, reset_less=True)
        whole = Signal()
        m.d.comb += whole.eq(bits[0])
        m.d.comb += self.o.payload.eq(bits[1:])
        m.d.sync += left.eq(left - 1)
        m.d.sync += self.o.valid.eq(0)
        m.d.sync += self.fault.eq(0)
        with m.FSM():
            with m.State("IDLE"):
                m.d.sync += left.eq(self._divisor // 2 - 1)
                m.d.sync += bits.eq(1 << BYTE)
                with m.If(~line):
                    m.next = "START"
            with m.State("START"), m.If(left == 0):
                m.d.sync += left.eq(self._divisor - 1)
                m.next = "BITS"
                with m.If(line):  # too short for a start bit
                    m.next = "IDLE"
            with m.State("BITS"), m.If(left == 0):
                m.d.sync += left.eq(self._divisor - 1)
                with m.If(~whole):
                    m.d.sync += bits.eq(Cat(bits[1:], line))
                with m.Else():
                    m.d.sync += [
                        self.o.valid.eq(line),
                        self.fault.eq(~line),
                        self.broken.eq(~line & ~bits[1:].any()),
                    ]
                    m.next = "IDLE"
                    with m.If(~line):
                        m.next = "LOW"
            with m.State("LOW"), m.If(line):
                m.d.sync += self.broken.eq(0)
                m.next = "IDLE"
        return m


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
        m.d.comb += self.i.ready.eq(~busy)
        m.d.comb += self.line.eq(~low)
        m.d.comb += low.eq(bits[0])
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
