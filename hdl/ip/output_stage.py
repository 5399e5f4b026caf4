"""The last stage of the output frames."""

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.lib.streams import SkidBuffer

OUTPUT_BEAT = data.StructLayout({"data": BITS, "user": 1, "last": 1})
"""A beat of an output frame; ``user`` in its last one: a reset cut the frame."""

CUT = (1 << BITS) - 1
"""The data of that last beat: no status, with which frames end, has all bits."""

RESULT_BEAT = data.StructLayout({"data": BITS, "last": 1, "started": BITS})
"""A beat of an output frame, and the time of the first taxel of its input frame."""


class OutputStage(wiring.Component):
    """Words on their way out; after a reset of the stages before it, it ends the frame that was cut.

    A soft reset leaves this stage alone, since a word that is offered has to stay until it is taken.

    =======  =======  ======================================================================
    opened   abort    words that enter the skid buffer
    =======  =======  ======================================================================
    0        0        the first one of a frame from ``i``
    1        0        the others; a ``restart`` leads to ``abort``
    1        1        ``CUT`` as a last word with ``user`` high, instead of those from ``i``
    =======  =======  ======================================================================

    ``latency``: one cycle.  The time is stored from a frame's second word on, before which the one before has ended.
    """

    latency = SkidBuffer.latency

    def __init__(self) -> None:
        super().__init__({
            "i": In(stream.Signature(RESULT_BEAT)),
            "o": Out(stream.Signature(OUTPUT_BEAT)),  # registered
            "restart": In(1),  # the stages before are reset, and what they offer is not taken
            "ended": Out(1),  # the last word of a complete frame is taken ...
            "started": Out(BITS),  # ... whose first taxel came at this time
            "busy": Out(1),  # a word waits
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.skid = skid = SkidBuffer(OUTPUT_BEAT)
        wiring.connect(m, skid.o, wiring.flipped(self.o))
        opened = Signal()  # words of a frame have entered, but not its last
        abort = Signal()
        started = Signal(BITS, reset_less=True)
        m.d.comb += [
            skid.i.valid.eq(abort | (self.i.valid & ~self.restart)),
            skid.i.p.data.eq(self.i.p.data | abort.replicate(BITS)),
            skid.i.p.user.eq(abort),
            skid.i.p.last.eq(abort | self.i.p.last),
            self.i.ready.eq(skid.i.ready & ~abort),
            self.ended.eq(self.o.valid & self.o.ready & self.o.p.last & ~self.o.p.user),
            self.started.eq(started),
            self.busy.eq(self.o.valid),
        ]
        m.d.sync += abort.eq(Mux(abort, ~skid.i.ready, self.restart & opened))
        with m.If(skid.i.valid & skid.i.ready):
            m.d.sync += opened.eq(~skid.i.p.last)
        with m.If(opened & skid.i.ready):
            m.d.sync += started.eq(self.i.p.started)
        return m
