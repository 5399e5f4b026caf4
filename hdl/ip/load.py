"""The way of the coefficients from a register to the core."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Shape, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.ip.crc import Crc32
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import delayed


class Load(wiring.Component):
    """Hands over the words that software writes, counts them and makes their checksum.

    Arguments:
        shape: of a coefficient.
        words: number of coefficients.

    Members:
        word, written: in, as software writes them; a word that comes while not ``ready`` is lost.
        expected: in, the checksum that the words should have.
        o: stream out, to the core.
        ready: out, the core waits for a word.
        count: out, a pulse for each word that is taken.
        crc, match: out, the checksum, and whether it is the expected one.
        loaded: out, all words are there; ``done``: out, a pulse for that, when their checksum is known.
        wrong: out, with ``done``: the checksum is another one.
    """

    def __init__(self, shape: Shape, words: int) -> None:
        self._words = words
        super().__init__(
            {
                "word": In(BITS),
                "written": In(1),
                "expected": In(BITS),
                "o": Out(stream.Signature(shape)),
                **dict.fromkeys(("ready", "count", "match", "loaded", "done", "wrong"), Out(1)),
                "crc": Out(BITS),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.crc = crc = Crc32()
        left = Signal(counter_shape(self._words), init=self._words)
        word = Signal(self.o.payload.shape(), reset_less=True)
        waits = Signal()
        taken = Signal()
        m.d.comb += [
            *(self.ready.eq(~waits & self.o.ready & ~self.loaded), taken.eq(self.written & self.ready)),
            *(self.o.valid.eq(waits), self.o.payload.eq(word), self.count.eq(taken)),
            *(crc.word.eq(self.word), crc.written.eq(taken), self.crc.eq(crc.crc)),
            self.done.eq(delayed(m, taken & (left == 1), crc.latency + 1, "last", control=True)),
            self.wrong.eq(self.done & ~self.match),
        ]
        m.d.sync += [self.match.eq(crc.crc == self.expected), self.loaded.eq(left == 0)]
        with m.If(taken):
            m.d.sync += [word.eq(self.word), waits.eq(1), left.eq(left - 1)]
        with m.Elif(self.o.ready):
            m.d.sync += waits.eq(0)
        return m
