"""Words that software writes: their CRC, and their way to a core."""

from typing import Any

from amaranth import Module, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS, BYTES
from tfra.hdl.lib.pipeline import register


class Crc(wiring.Component):
    """CRC-32, that of zlib, Ethernet and PNG, of words whose lowest byte comes first; a byte a cycle.

    Words may come every ``BYTES`` cycles; the CRC of a word is there a cycle after its last byte.
    """

    def __init__(self) -> None:
        super().__init__({
            "word": In(BITS),
            "start": In(1),  # pulse: there is a word
            "restart": In(1),  # pulse: forget all words
            "crc": Out(BITS),  # of the words so far, 0 without any
            "done": Out(1),  # pulse: it covers the last word and no other has come
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crc = crc = CRC32_ISO_HDLC(data_width=8).create()
        rest = Signal(BITS, reset_less=True)
        left = Signal(BYTES)  # a one for each byte
        m.d.sync += rest.eq(rest[8:])
        m.d.sync += left.eq(left[1:])
        with m.If(self.start):
            m.d.sync += rest.eq(self.word)
            m.d.sync += left.eq(-1)
        m.d.comb += [
            crc.data.eq(rest[:8]),
            crc.valid.eq(left[0]),
            crc.start.eq(self.restart),
            self.crc.eq(crc.crc),
            self.done.eq(register(m, (left == 1) & ~self.start, "done", control=True)),
        ]
        return m


LOADING = wiring.Signature({
    "word": Out(BITS),  # of software
    "written": Out(1),  # its pulse
    "checksum": Out(BITS),  # the expected CRC
    "ready": In(1),  # the core takes a word
    "taken": In(1),  # pulse: a word is taken
    "crc": In(BITS),  # of all words taken
    "match": In(1),  # it is the expected one, a cycle later
    "loaded": In(1),  # the core has all coefficients
    "done": In(1),  # pulse: the last coefficient was taken ...
    "wrong": In(1),  # ... and the CRC is not the expected one
})
"""The way of software to the coefficients, as it drives it."""


class Load(wiring.Component):
    """Pass words to the core, whose coefficients have ``bits``, while it takes them, and check their CRC.

    No word waits: a core that loads is ready in every cycle from the reset to the last coefficient, and software can't
    write more often than the CRC takes.
    """

    def __init__(self, bits: int) -> None:
        super().__init__({"software": In(LOADING), "o": Out(stream.Signature(signed(bits)))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crc = crc = Crc()
        software, o = self.software, self.o
        m.d.comb += [
            o.payload.eq(software.word[: len(o.payload)]),
            o.valid.eq(software.written),
            software.ready.eq(o.ready),
            software.taken.eq(software.written & o.ready),
            software.loaded.eq(~o.ready),
            crc.word.eq(software.word),
            crc.start.eq(software.taken),
            software.crc.eq(crc.crc),
            software.match.eq(register(m, crc.crc == software.checksum, "match")),
            software.done.eq(register(m, crc.done & software.loaded, "done", control=True)),
            software.wrong.eq(software.done & ~software.match),
        ]
        return m
