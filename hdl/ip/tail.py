"""The last stage of the output frames."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.ip.ports import ANSWER, OUTPUT
from tfra.hdl.lib.streams import SkidBuffer


class Tail(wiring.Component):
    """Words on their way out; after a reset of the stages before it, it ends the frame that was cut.

    A soft reset leaves this stage alone, since a word that is offered has to stay until it is taken.

    ``latency``: one cycle.  A frame has three words or more, so that its time is read before the next one ends.

    Members: ``i``: stream in; ``restart``: in, the stages before are reset; ``o``: stream out, registered; ``ended``:
    out, the last word of a complete frame is taken; ``started``: out, the time of that frame's first taxel; ``busy``:
    out, a word waits.
    """

    latency = SkidBuffer.latency

    def __init__(self) -> None:
        streams = {"i": In(stream.Signature(ANSWER)), "o": Out(stream.Signature(OUTPUT))}
        super().__init__({**streams, "restart": In(1), "ended": Out(1), "started": Out(BITS), "busy": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.spare = spare = SkidBuffer(OUTPUT)
        wiring.connect(m, spare.o, wiring.flipped(self.o))
        opened = Signal()  # words of a frame have entered, but not its last
        abort = Signal()
        started = Signal(BITS, reset_less=True)
        enters = spare.i.valid & spare.i.ready
        m.d.comb += [
            spare.i.valid.eq(abort | (self.i.valid & ~self.restart)),
            self.i.ready.eq(spare.i.ready & ~abort & ~self.restart),
            *(spare.i.p.data.eq(self.i.p.data), spare.i.p.user.eq(abort), spare.i.p.last.eq(abort | self.i.p.last)),
            self.ended.eq(self.o.valid & self.o.ready & self.o.p.last & ~self.o.p.user),
            *(self.started.eq(started), self.busy.eq(self.o.valid)),
        ]
        m.d.sync += abort.eq(Mux(abort, ~spare.i.ready, self.restart & opened))
        with m.If(enters):
            m.d.sync += opened.eq(~spare.i.p.last)
            with m.If(spare.i.p.last & ~abort):
                m.d.sync += started.eq(self.i.p.started)
        return m
