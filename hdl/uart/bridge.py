"""A core behind a serial line: frames of codes in, frames of result words out.

```
 bytes ─▶ Decoder ─▶ Incoming ─ load, taxel ─▶ core ─ result ─▶ Outgoing ─▶ Encoder ─▶ bytes
```
"""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Module, Mux, Signal, signed, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.uart.rx import BYTE
from tfra.hdl.uart.slip import FRAMED, Decoder, Encoder
from tfra.model.fixed.design import Design

CODE_BYTES = 2
"""Bytes of a code, the lowest first."""
WORD_BYTES = 4
"""Bytes of a result word, the lowest first; its sign fills them up."""


def coefficient_bytes(design: Design) -> int:
    """Bytes of a coefficient, the lowest first."""
    return -(-design.coefficient_word // BYTE)


class Incoming(wiring.Component):
    """Pass complete frames to the core, and coefficients before the first of them.

    A frame is stored until its end has come.  One that is too short or too long, that has lost a byte, or that ends
    while the one before still waits for the core is dropped whole.

    Members:
        i: bytes of frames, in; they are apart by at least two cycles.
        end, fault: pulses: the frame has ended; a byte of it was lost.
        taxel: codes of complete frames, out.
        load: coefficients, out, while its ``ready`` is high; the core is then ready in every cycle.
        dropped: pulse: a frame that was not empty was dropped.
    """

    def __init__(self, design: Design) -> None:
        self._taxels = design.sensor.taxels
        self._bytes = coefficient_bytes(design)
        members = {"i": In(always_ready_stream(BYTE)), "end": In(1), "fault": In(1), "dropped": Out(1)}
        load = stream.Signature(signed(design.coefficient_word))
        super().__init__({**members, "taxel": Out(stream.Signature(ports.taxel(design))), "load": Out(load)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        place_bits = (self._taxels - 1).bit_length()
        code = self.taxel.payload
        m.submodules.frames = frames = Memory(shape=unsigned(len(code)), depth=2 << place_bits, init=[])
        write, read = frames.write_port(), frames.read_port()
        before = Signal(BYTE * max(CODE_BYTES - 1, self._bytes - 1), reset_less=True)
        index, number = Signal(range(max(CODE_BYTES, self._bytes))), Signal(range(self._taxels + 1))
        loading, complete, bad, bank, waiting = (
            Signal(name=name) for name in ("loading", "complete", "bad", "bank", "waiting")
        )
        word = Cat(before, self.i.payload)
        m.d.comb += [
            loading.eq(self.load.ready),
            complete.eq(self.i.valid & (index == Mux(loading, self._bytes - 1, CODE_BYTES - 1))),
            *(self.load.valid.eq(loading & complete), self.load.payload.eq(word[-BYTE * self._bytes :])),
            write.addr.eq(Cat(number[:place_bits], bank)),
            *(write.data.eq(word[-BYTE * CODE_BYTES :]), write.en.eq(~loading & complete)),
        ]
        with m.If(self.i.valid):
            m.d.sync += [before.eq(word[BYTE:]), index.eq(Mux(complete, 0, index + 1))]
        with m.If(write.en & (number != self._taxels)):
            m.d.sync += number.eq(number + 1)
        with m.If(self.fault | (write.en & (number == self._taxels))):
            m.d.sync += bad.eq(1)
        good = ~bad & (index == 0) & (number == self._taxels) & ~waiting
        empty = ~bad & (index == 0) & (number == 0)
        self._hand_over(m, read, bank, waiting)
        with m.If(self.end):
            m.d.comb += self.dropped.eq(~good & ~empty)
            m.d.sync += [index.eq(0), number.eq(0), bad.eq(0)]
            with m.If(good):
                m.d.sync += [bank.eq(~bank), waiting.eq(1)]
        return m

    def _hand_over(self, m: Module, read: Any, bank: Signal, waiting: Signal) -> None:
        """Pass the frame of the other bank to the core while it is ``waiting``, a code every second cycle."""
        place, found = Signal(range(self._taxels)), Signal()
        m.d.comb += [
            read.addr.eq(Cat(place, ~bank)),
            *(self.taxel.payload.eq(read.data), self.taxel.valid.eq(found)),
        ]
        with m.If(~found):
            m.d.sync += found.eq(waiting)
        with m.Elif(self.taxel.ready):
            m.d.sync += [found.eq(0), place.eq(place + 1)]
            with m.If(place == self._taxels - 1):
                m.d.sync += [place.eq(0), waiting.eq(0)]


class Outgoing(wiring.Component):
    """Cut result words into bytes.  Members: ``i``: the core's words, in; ``o``: bytes of frames, out."""

    latency = 0

    def __init__(self, design: Design) -> None:
        super().__init__({"i": In(stream.Signature(ports.result(design))), "o": Out(stream.Signature(FRAMED))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word, place, last = Signal(signed(BYTE * WORD_BYTES)), Signal(range(WORD_BYTES)), Signal()
        m.d.comb += [
            *(word.eq(self.i.payload.data), last.eq(place == WORD_BYTES - 1)),
            self.o.payload.byte.eq(word.word_select(place, BYTE)),
            self.o.payload.last.eq(last & self.i.payload.last),
            *(self.o.valid.eq(self.i.valid), self.i.ready.eq(self.o.ready & last)),
        ]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += place.eq(place + 1)
        return m


class Bridge(wiring.Component):
    """Both directions of the line, between UART and core.

    Members: ``i``: bytes of the line, in, without backpressure; ``fault``: pulse: one was lost; ``o``: bytes of the
    line, out; ``load``, ``taxel``, ``dropped`` as in :class:`Incoming`; ``result``: the core's words.
    """

    def __init__(self, design: Design) -> None:
        self._in, self._out = Incoming(design), Outgoing(design)
        inside = self._in.signature.members
        kept = {name: inside[name] for name in ("load", "taxel", "dropped", "fault", "i")}
        super().__init__({**kept, "result": self._out.signature.members["i"], "o": Out(stream.Signature(BYTE))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.incoming, m.submodules.outgoing = incoming, outgoing = self._in, self._out
        m.submodules.decoder, m.submodules.encoder = decoder, encoder = Decoder(), Encoder()
        connect(m, flipped(self.i), decoder.i)
        connect(m, decoder.o, incoming.i)
        connect(m, incoming.load, flipped(self.load))
        connect(m, incoming.taxel, flipped(self.taxel))
        connect(m, flipped(self.result), outgoing.i)
        connect(m, outgoing.o, encoder.i)
        connect(m, encoder.o, flipped(self.o))
        m.d.comb += [
            incoming.end.eq(decoder.end),
            incoming.fault.eq(decoder.fault | self.fault),
            self.dropped.eq(incoming.dropped),
        ]
        return m
