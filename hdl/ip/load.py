"""Words that software writes load a core."""

from typing import Any

from amaranth import Module, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.ip.crc import Crc
from tfra.hdl.lib.pipeline import register

LOADING = wiring.Signature(
    {
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
    }
)
"""The way of software to the coefficients, as it drives it."""


class Load(wiring.Component):
    """Pass words to the core while it takes them, and check their CRC.

    No word waits: a core that loads is ready in every cycle from the reset to the last coefficient, and software can't
    write more often than the CRC takes.

    Arguments:
        bits: of a coefficient.
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
