"""CRC-32 of a sequence of words."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS, BYTES

POLYNOMIAL = 0xEDB88320
"""Of zlib, Ethernet and PNG, its lowest bit first."""


class Crc32(wiring.Component):
    """CRC-32 of 32-bit words, lowest byte first, a byte a cycle; 0 before the first word.

    Members:
        clear: in, begins anew.
        word, written: in, ``written`` is high for a cycle; the next word comes ``interval`` cycles later, or after that.
        crc: out, ``latency`` cycles after ``written``.
    """

    interval = BYTES
    latency = BYTES + 1

    def __init__(self) -> None:
        super().__init__({"clear": In(1), "word": In(BITS), "written": In(1), "crc": Out(BITS)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        crc = Signal(BITS)
        left = Signal(BITS, reset_less=True)
        bytes_left = Signal(BYTES)
        m.d.comb += self.crc.eq(crc)
        m.d.sync += [left.eq(left >> 8), bytes_left.eq(bytes_left >> 1)]
        with m.If(bytes_left[0]):
            m.d.sync += crc.eq(~self._step(~crc ^ left[:8]))
        with m.If(self.written):
            m.d.sync += [left.eq(self.word), bytes_left.eq(~0)]
        with m.If(self.clear):
            m.d.sync += [crc.eq(0), bytes_left.eq(0)]
        return m

    @staticmethod
    def _step(value: Value) -> Value:
        """Eight steps of the division by the polynomial."""
        for _ in range(8):
            value = Cat(value[1:], 0) ^ Mux(value[0], POLYNOMIAL, 0)
        return value
