"""A frame on its way to the core: its repairs, then its facts, then its codes."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.front_end.codes import stored_code
from tfra.hdl.front_end.ports import FACTS
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import wrapping_counter
from tfra.hdl.lib.streams import SkidBuffer
from tfra.model.fixed.design import Design


class Handover(wiring.Component):
    """Hands over one frame after the other, while it is ``waiting``.

    Members:
        waiting: in, a complete frame is there, and its codes are written.
        repair: out, the frame is being repaired, until ``repaired``, in.
        facts: in, those of the frame, when valid; ``o``: stream out, the facts; they are taken before the first code.
        address, read: of a code, out; ``stored``: in, a cycle later.
        silent: in, no code of the frame reaches the threshold of a contact.
        codes: stream out, registered.
        done: out, the frame's last code is taken.
    """

    latency = 4
    """Cycles from the first one in which a frame is ``waiting`` to the transfer of its first code, without repairs."""

    def __init__(self, design: Design) -> None:
        taxels, code = design.sensor.taxels, stored_code(design.adc.bits)
        self._taxels = taxels
        super().__init__(
            {
                "waiting": In(1),
                "repair": Out(1),
                "repaired": In(1),
                "facts": In(stream.Signature(FACTS)),
                "o": Out(stream.Signature(FACTS)),
                "address": Out(counter_shape(taxels - 1)),
                "read": Out(1),
                "stored": In(code),
                "silent": In(1),
                "codes": Out(stream.Signature(code.members["code"])),
                "done": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        layout = data.StructLayout({"code": self.codes.payload.shape(), "end": 1})
        m.submodules.spare = spare = SkidBuffer(layout)
        advance = spare.i.ready
        reading = Signal()
        address, last = wrapping_counter(m, reading & advance, self._taxels, "address")
        with m.If(advance):
            m.d.sync += [spare.i.valid.eq(reading), spare.i.payload.end.eq(last)]
        m.d.comb += [
            *(self.address.eq(address), self.read.eq(advance)),
            self.o.payload.eq(self.facts.payload),
            spare.i.payload.code.eq(Mux(self.silent | self.stored.small, 0, self.stored.code)),
            *(self.codes.valid.eq(spare.o.valid), self.codes.payload.eq(spare.o.payload.code)),
            spare.o.ready.eq(self.codes.ready),
            self.done.eq(spare.o.payload.end & self.codes.valid & self.codes.ready),
        ]
        with m.FSM():
            with m.State("REPAIR"):
                ready = self.waiting & self.repaired
                m.d.comb += self.repair.eq(self.waiting)
                with m.If(ready):
                    m.next = "FACTS"
            with m.State("FACTS"):
                m.d.comb += [self.o.valid.eq(self.facts.valid), self.facts.ready.eq(self.o.ready)]
                with m.If(self.o.valid & self.o.ready):
                    m.next = "READ"
            with m.State("READ"):
                m.d.comb += reading.eq(1)
                with m.If(last & advance):
                    m.next = "SEND"
            with m.State("SEND"), m.If(self.done):
                m.next = "REPAIR"
        return m
