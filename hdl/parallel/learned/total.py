"""The outputs of the network: sums of the parts that three products have in them."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import delayed, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.hdl.parallel.payloads import frame_facts, product, vector_quad
from tfra.model.fixed.learned.design import LearnedDesign

PARTS = ("direct", "read1", "read2")
"""Operators of the parts, in the order in which those of a frame come."""

QUADS = 2
"""Quads of the outputs: the resultant, and the uncertainty."""


class Total(wiring.Component):
    """Sums of two quads over the parts of a frame, zero without contact.

    ::

        result -> part ----> + ---> sum ---> total, after the last part
        memory -> before ---'         '-> memory, after the others

    Parts of several frames interleave.  At most ``FRAMES`` are between their first and their last part, and the sums
    of each have a place in the memory after the first part, and another one after the second.  A part of a frame comes
    a product later than the one before, at least a cycle after its last quad.  No multiplier.
    """

    latency = 3
    """Cycles from the transfer of a quad of the last part to that of its sum."""

    def __init__(self, design: LearnedDesign) -> None:
        self._design = design
        super().__init__({
            # Results of all products; those of ``PARTS`` are looked at.
            "result": In(always_ready_stream(product(design))),
            # Fact of the frame, there before its last part, taken two cycles after the last quad.
            "frame": In(stream.Signature(frame_facts(design))),
            "total": Out(always_ready_stream(vector_quad(design))),  # two quads a frame
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        quad = self.total.payload.shape()
        sums = Ram(m, "sums", quad, 2 * FRAMES * QUADS)
        # TIMING: products -> words and place of what is there so far
        arrives = [
            register(m, self.result.valid & self.result.p.kind[self._design.kinds.index(name)], name, control=True)
            for name in PARTS
        ]
        first, second, third = (
            wrapping_counter(m, part, FRAMES * QUADS, f"{name}_quad")[0]
            for name, part in zip(PARTS, arrives, strict=True)
        )
        no_contact = register(m, arrives[2] & ~self.frame.p.contact, "no_contact")
        total = Signal(quad, name="sum", reset_less=True)
        so_far = sums.look_up(Mux(arrives[2], Cat(third, 1), Cat(second, 0)))
        for word, part, before in zip(total, self.result.p.words, so_far, strict=True):
            # TIMING: memory -> sum
            part = delayed(m, part, 2, "part")
            before = register(m, Mux(arrives[0], 0, before), "before")
            m.d.sync += word.eq(Mux(no_contact, 0, part + before))
        again = delayed(m, arrives[0] | arrives[1], self.latency - 1, "again", control=True)
        place = delayed(m, Mux(arrives[1], Cat(second, 1), Cat(first, 0)), self.latency - 1, "write_place")
        sums.write(again, place, total)
        m.d.comb += [
            self.frame.ready.eq(register(m, arrives[2] & third[0], "taken", control=True)),
            self.total.valid.eq(delayed(m, arrives[2], self.latency - 1, "last_part", control=True)),
            self.total.payload.eq(total),
        ]
        return m
