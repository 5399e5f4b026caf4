"""Mirror folding in hardware: four mirror taxels to four parities and back, one quad per cycle."""

from typing import Any

from amaranth import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import quad


class Butterfly(wiring.Component):
    """The 4-point Walsh-Hadamard transform of :func:`tfra.model.fixed.butterfly.butterfly`.

    ::

        a, b, c, d -> [a + b, a - b, c + d, c - d] -> [a+b+c+d, a-b+c-d, a+b-c-d, a-b-c+d]

    An elastic pipeline of two adder levels, each followed by a register: one quad per cycle, eight adders.
    """

    latency = 2
    """Cycles from the transfer of a quad in to the transfer of the same quad out."""

    def __init__(self, bits: int) -> None:
        self._bits = bits
        super().__init__({
            "i": In(stream.Signature(quad(bits))),
            "o": Out(stream.Signature(quad(bits + 2))),  # registered
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        half = Signal(quad(self._bits + 1), reset_less=True)
        whole = Signal(quad(self._bits + 2), reset_less=True)
        half_valid = Signal()
        whole_valid = Signal()
        advance = Signal()
        x = self.i.payload
        m.d.comb += [
            advance.eq(~whole_valid | self.o.ready),
            self.i.ready.eq(advance),
            self.o.valid.eq(whole_valid),
            self.o.payload.eq(whole),
        ]
        with m.If(advance):
            m.d.sync += half_valid.eq(self.i.valid)
            m.d.sync += whole_valid.eq(half_valid)
            for k in (0, 2):
                m.d.sync += half[k].eq(x[k] + x[k + 1])
                m.d.sync += half[k + 1].eq(x[k] - x[k + 1])
            for k in (0, 1):
                m.d.sync += whole[k].eq(half[k] + half[k + 2])
                m.d.sync += whole[k + 2].eq(half[k] - half[k + 2])
        return m
