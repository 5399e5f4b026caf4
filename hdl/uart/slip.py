"""Frames of bytes on a serial line, as RFC 1055 (SLIP) has them."""

from typing import Any

from amaranth import Module, Mux
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.uart.uart import BYTE

END, ESC, ESC_END, ESC_ESC = 0xC0, 0xDB, 0xDC, 0xDD
"""End of a frame; escape; what follows it for a byte that equals END, and for one that equals ESC."""

FRAMED = data.StructLayout({"byte": BYTE, "last": 1})
"""A byte of a frame."""


class Decoder(wiring.Component):
    """Take the escapes out of a line's bytes."""

    def __init__(self) -> None:
        super().__init__({
            "i": In(always_ready_stream(BYTE)),  # bytes of the line
            "o": Out(always_ready_stream(BYTE)),  # bytes of a frame, in the same cycle
            "end": Out(1),  # pulse: the frame has ended
            "fault": Out(1),  # pulse: an escape that stands for nothing, which no frame has
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word = self.i.payload
        m.d.comb += self.o.payload.eq(word)
        with m.FSM():
            with m.State("PLAIN"), m.If(self.i.valid):
                m.d.comb += self.end.eq(word == END)
                m.d.comb += self.o.valid.eq((word != END) & (word != ESC))
                with m.If(word == ESC):
                    m.next = "ESCAPED"
            with m.State("ESCAPED"), m.If(self.i.valid):
                known = (word == ESC_END) | (word == ESC_ESC)
                m.d.comb += [
                    self.o.payload.eq(Mux(word[0], ESC, END)),
                    self.o.valid.eq(known),
                    self.fault.eq(~known),
                    self.end.eq(word == END),  # it is also an end
                ]
                m.next = "PLAIN"
        return m


class Encoder(wiring.Component):
    """Put frames on a line: END, the bytes with escapes, END.

    The END before a frame separates it from what was on the line before; receivers ignore empty frames.
    """

    def __init__(self) -> None:
        super().__init__({
            "i": In(stream.Signature(FRAMED)),  # bytes of frames
            "o": Out(stream.Signature(BYTE)),  # bytes of the line, in the same cycle
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word, taken = self.i.payload.byte, self.o.valid & self.o.ready
        special = (word == END) | (word == ESC)
        last = self.i.payload.last
        m.d.comb += self.o.valid.eq(self.i.valid)
        with m.FSM():
            with m.State("BEGIN"):
                m.d.comb += self.o.payload.eq(END)
                with m.If(taken):
                    m.next = "BYTE"
            with m.State("BYTE"):
                m.d.comb += self.o.payload.eq(Mux(special, ESC, word))
                m.d.comb += self.i.ready.eq(self.o.ready & ~special)
                with m.If(taken & special):
                    m.next = "ESCAPED"
                with m.Elif(taken & last):
                    m.next = "END"
            with m.State("ESCAPED"):
                m.d.comb += self.o.payload.eq(Mux(word == END, ESC_END, ESC_ESC))
                m.d.comb += self.i.ready.eq(self.o.ready)
                with m.If(taken):
                    m.next = "BYTE"
                    with m.If(last):
                        m.next = "END"
            with m.State("END"):
                m.d.comb += self.o.payload.eq(END)
                m.d.comb += self.o.valid.eq(1)
                with m.If(taken):
                    m.next = "BEGIN"
        return m
