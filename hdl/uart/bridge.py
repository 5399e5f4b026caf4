"""A core behind a serial line: frames of codes in, frames of result words out.

```
 bytes ─▶ Decoder ─▶ frames ─ load, taxel ─▶ core ─ result ─▶ Encoder ─▶ bytes
```
"""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from tfra.hdl.interface import ports
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.uart.slip import Decoder, Encoder
from tfra.hdl.uart.uart import BYTE
from tfra.model.fixed.design import Design

CODE_BYTES = 2
"""Bytes of a code, the lowest first."""
WORD_BYTES = 4
"""Bytes of a result word, the lowest first; its sign fills them up."""


def coefficient_bytes(design: Design) -> int:
    """Bytes of a coefficient, the lowest first."""
    return -(-design.coefficient_word // BYTE)


class Bridge(wiring.Component):
    """Both directions of the line, between UART and core.

    Complete frames pass to the core, and coefficients before the first of them.  A frame is stored until its end has
    come.  One that is too short or too long, that has lost a byte, or that ends while the one before still waits for
    the core is dropped whole.
    """

    def __init__(self, design: Design) -> None:
        self._taxels = design.sensor.taxels
        self._bytes = coefficient_bytes(design)
        super().__init__({
            "i": In(always_ready_stream(BYTE)),  # bytes of the line, at least two cycles apart
            "fault": In(1),  # pulse: one of them was lost
            "dropped": Out(1),  # pulse: a frame that was not empty was dropped
            "taxel": Out(stream.Signature(ports.taxel(design))),  # codes of complete frames
            # Coefficients, while its ``ready`` is high; the core is then ready in every cycle.
            "load": Out(stream.Signature(signed(design.coefficient_word))),
            "result": In(stream.Signature(ports.result(design))),  # the core's words
            "o": Out(stream.Signature(BYTE)),  # bytes of the line
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.decoder = decoder = Decoder()
        m.submodules.encoder = encoder = Encoder()
        connect(m, flipped(self.i), decoder.i)
        connect(m, encoder.o, flipped(self.o))
        self._receive(m, decoder)
        self._answer(m, encoder)
        return m

    def _receive(self, m: Module, decoder: Decoder) -> None:
        """Put bytes together to coefficients, which pass at once, and to codes, which are stored."""
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
        word = Cat(before, decoder.o.payload)
        m.d.comb += [
            loading.eq(self.load.ready),
            complete.eq(decoder.o.valid & (index == Mux(loading, self._bytes - 1, CODE_BYTES - 1))),
            self.load.valid.eq(loading & complete),
            self.load.payload.eq(word[-BYTE * self._bytes :]),
            stores.eq(~loading & complete),
        ]
        frames.write(stores, Cat(number[:index_bits], page), word[-BYTE * CODE_BYTES :])
        with m.If(decoder.o.valid):
            m.d.sync += before.eq(word[BYTE:])
            m.d.sync += index.eq(Mux(complete, 0, index + 1))
        with m.If(stores & (number != self._taxels)):
            m.d.sync += number.eq(number + 1)
        with m.If(decoder.fault | self.fault | (stores & (number == self._taxels))):
            m.d.sync += bad.eq(1)
        good = ~bad & (index == 0) & (number == self._taxels) & ~waiting
        empty = ~bad & (index == 0) & (number == 0)
        self._send(m, frames, page, waiting)
        with m.If(decoder.end):
            m.d.comb += self.dropped.eq(~good & ~empty)
            m.d.sync += index.eq(0)
            m.d.sync += number.eq(0)
            m.d.sync += bad.eq(0)
            with m.If(good):
                m.d.sync += page.eq(~page)
                m.d.sync += waiting.eq(1)

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
            m.d.sync += valid.eq(0)
            m.d.sync += index.eq(index + 1)
            with m.If(index == self._taxels - 1):
                m.d.sync += index.eq(0)
                m.d.sync += waiting.eq(0)

    def _answer(self, m: Module, encoder: Encoder) -> None:
        """Cut result words into bytes."""
        word = Signal(signed(BYTE * WORD_BYTES))
        index = Signal(range(WORD_BYTES))
        last = Signal()
        m.d.comb += [
            word.eq(self.result.payload.data),
            last.eq(index == WORD_BYTES - 1),
            encoder.i.payload.byte.eq(word.word_select(index, BYTE)),
            encoder.i.payload.last.eq(last & self.result.payload.last),
            encoder.i.valid.eq(self.result.valid),
            self.result.ready.eq(encoder.i.ready & last),
        ]
        with m.If(encoder.i.valid & encoder.i.ready):
            m.d.sync += index.eq(index + 1)
