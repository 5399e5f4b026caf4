"""CRC-32 of words."""

from typing import Any

from amaranth import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS, BYTES
from tfra.hdl.lib.pipeline import register


class Crc(wiring.Component):
    """CRC-32, that of zlib, Ethernet and PNG, of words whose lowest byte comes first; a byte a cycle.

    Words may come every ``interval`` cycles.  ``latency`` counts cycles from a word to its CRC.
    """

    interval = BYTES
    latency = 1 + BYTES

    def __init__(self) -> None:
        super().__init__(
            {
                "word": In(BITS),
                "start": In(1),  # pulse: there is a word
                "restart": In(1),  # pulse: forget all words
                "crc": Out(BITS),  # of the words so far, 0 without any
                "done": Out(1),  # pulse: it covers the last word and no other has come
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crc = crc = CRC32_ISO_HDLC(data_width=8).create()
        rest = Signal(BITS, reset_less=True)
        left = Signal(BYTES)  # a one for each byte
        m.d.sync += [rest.eq(rest[8:]), left.eq(left[1:])]
        with m.If(self.start):
            m.d.sync += [rest.eq(self.word), left.eq(-1)]
        m.d.comb += [
            crc.data.eq(rest[:8]),
            crc.valid.eq(left[0]),
            crc.start.eq(self.restart),
            self.crc.eq(crc.crc),
            self.done.eq(register(m, (left == 1) & ~self.start, "done", control=True)),
        ]
        return m
