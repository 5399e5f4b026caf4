"""Words that software writes load a core."""

from __future__ import annotations

from typing import Any

from amaranth import Module, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.ip.crc import Crc
from tfra.hdl.lib.pipeline import register


class Load(wiring.Component):
    """Passes words to the core while it takes them, and checks their CRC.

    No word waits: a core that loads is ready in every cycle from the reset to the last coefficient, and software can't
    write more often than the CRC takes.

    Arguments: ``bits``: of a coefficient.

    Members:
        word, written: in, a word of software and its pulse.
        checksum: in, the expected CRC.
        o: stream out, to the core.
        taken: out, a word is taken.
        crc: out, of all words taken; ``match``: it is the expected one, a cycle later.
        loaded: out, the core has all coefficients.
        done, wrong: out, pulses: the last coefficient was taken, and the CRC is not the expected one.
    """

    def __init__(self, bits: int) -> None:
        inputs = {"word": In(BITS), "written": In(1), "checksum": In(BITS)}
        outputs = dict.fromkeys(("taken", "match", "loaded", "done", "wrong"), Out(1))
        super().__init__({**inputs, "o": Out(stream.Signature(signed(bits))), "crc": Out(BITS), **outputs})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crc = crc = Crc()
        m.d.comb += [
            *(self.o.payload.eq(self.word[: len(self.o.payload)]), self.o.valid.eq(self.written)),
            *(self.taken.eq(self.written & self.o.ready), self.loaded.eq(~self.o.ready)),
            *(crc.word.eq(self.word), crc.start.eq(self.taken), self.crc.eq(crc.crc)),
            self.match.eq(register(m, crc.crc == self.checksum, "match")),
            self.done.eq(register(m, crc.done & self.loaded, "done", control=True)),
            self.wrong.eq(self.done & ~self.match),
        ]
        return m
