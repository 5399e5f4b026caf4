"""A core behind a serial line: frames of codes in, frames of result words out.

```
 bytes ─▶ Decoder ─▶ Incoming ─ load, taxel ─▶ core ─ result ─▶ Outgoing ─▶ Encoder ─▶ bytes
```
"""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.ram import Ram
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
    """

    def __init__(self, design: Design) -> None:
        self._taxels = design.sensor.taxels
        self._bytes = coefficient_bytes(design)
        super().__init__(
            {
                "i": In(always_ready_stream(BYTE)),  # bytes of frames, at least two cycles apart
                "end": In(1),  # pulse: the frame has ended
                "fault": In(1),  # pulse: a byte of it was lost
                "dropped": Out(1),  # pulse: a frame that was not empty was dropped
                "taxel": Out(stream.Signature(ports.taxel(design))),  # codes of complete frames
                # Coefficients, while its ``ready`` is high; the core is then ready in every cycle.
                "load": Out(stream.Signature(signed(design.coefficient_word))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        index_bits = (self._taxels - 1).bit_length()
        frames = Ram(m, "frames", self.taxel.p.shape(), 2 << index_bits)
        before = Signal(BYTE * max(CODE_BYTES - 1, self._bytes - 1), reset_less=True)
        index = Signal(range(max(CODE_BYTES, self._bytes)))  # of the byte in its code or coefficient
        number = Signal(range(self._taxels + 1))  # of the code in its frame
        loading = Signal()
        complete = Signal()
        stores = Signal()
        bad = Signal()
        page = Signal()
        waiting = Signal()
        word = Cat(before, self.i.payload)
        m.d.comb += [
            loading.eq(self.load.ready),
            complete.eq(self.i.valid & (index == Mux(loading, self._bytes - 1, CODE_BYTES - 1))),
            self.load.valid.eq(loading & complete),
            self.load.payload.eq(word[-BYTE * self._bytes :]),
            stores.eq(~loading & complete),
        ]
        frames.write(stores, Cat(number[:index_bits], page), word[-BYTE * CODE_BYTES :])
        with m.If(self.i.valid):
            m.d.sync += [before.eq(word[BYTE:]), index.eq(Mux(complete, 0, index + 1))]
        with m.If(stores & (number != self._taxels)):
            m.d.sync += number.eq(number + 1)
        with m.If(self.fault | (stores & (number == self._taxels))):
            m.d.sync += bad.eq(1)
        good = ~bad & (index == 0) & (number == self._taxels) & ~waiting
        empty = ~bad & (index == 0) & (number == 0)
        self._send(m, frames, page, waiting)
        with m.If(self.end):
            m.d.comb += self.dropped.eq(~good & ~empty)
            m.d.sync += [index.eq(0), number.eq(0), bad.eq(0)]
            with m.If(good):
                m.d.sync += [page.eq(~page), waiting.eq(1)]
        return m

    def _send(self, m: Module, frames: Ram, page: Value, waiting: Signal) -> None:
        """Pass the frame of the other page to the core while it is ``waiting``, a code every second cycle."""
        index = Signal(range(self._taxels))
        valid = Signal()
        m.d.comb += [
            self.taxel.payload.eq(frames.read(Cat(index, ~page))),
            self.taxel.valid.eq(valid),
        ]
        with m.If(~valid):
            m.d.sync += valid.eq(waiting)
        with m.Elif(self.taxel.ready):
            m.d.sync += [valid.eq(0), index.eq(index + 1)]
            with m.If(index == self._taxels - 1):
                m.d.sync += [index.eq(0), waiting.eq(0)]


class Outgoing(wiring.Component):
    """Cut result words into bytes."""

    latency = 0

    def __init__(self, design: Design) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(ports.result(design))),  # the core's words
                "o": Out(stream.Signature(FRAMED)),  # bytes of frames
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word = Signal(signed(BYTE * WORD_BYTES))
        index = Signal(range(WORD_BYTES))
        last = Signal()
        m.d.comb += [
            word.eq(self.i.payload.data),
            last.eq(index == WORD_BYTES - 1),
            self.o.payload.byte.eq(word.word_select(index, BYTE)),
            self.o.payload.last.eq(last & self.i.payload.last),
            self.o.valid.eq(self.i.valid),
            self.i.ready.eq(self.o.ready & last),
        ]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += index.eq(index + 1)
        return m


class Bridge(wiring.Component):
    """Both directions of the line, between UART and core."""

    def __init__(self, design: Design) -> None:
        self._in, self._out = Incoming(design), Outgoing(design)
        incoming, outgoing = self._in.signature.members, self._out.signature.members
        super().__init__(
            {
                "i": incoming["i"],  # bytes of the line
                "fault": incoming["fault"],  # pulse: one of them was lost
                "load": incoming["load"],
                "taxel": incoming["taxel"],
                "dropped": incoming["dropped"],
                "result": outgoing["i"],  # the core's words
                "o": Out(stream.Signature(BYTE)),  # bytes of the line
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.incoming = incoming = self._in
        m.submodules.outgoing = outgoing = self._out
        m.submodules.decoder = decoder = Decoder()
        m.submodules.encoder = encoder = Encoder()
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
