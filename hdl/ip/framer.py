"""Frames of the output: a head, then the words of the core."""

from __future__ import annotations

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.bus.map import BITS
from tfra.hdl.front_end.ports import FACTS
from tfra.hdl.interface.ports import result
from tfra.hdl.ip.beats import OUTPUT
from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.streams import PerFrameQueue
from tfra.model.fixed.design import Design
from tfra.model.tfra import Status

HEAD = 2
"""Beats of the head."""

FORM = 1
"""Number of this form of frames, in the highest byte of the head's second beat."""

FRAMES = 15
"""Frames between the front end and the last beat of their result, at most."""




class Framer(wiring.Component):
    """Puts the facts of a frame before its words, and leaves out those of the forces if nobody wants them.

    Arguments:
        design: of the core, whose words have at most 32 bits; ``ValueError`` is raised for others.
        flags: bit of each of ``FLAGS`` in the head's second beat.

    Members:
        facts: stream in, one transfer a frame, before its first word.
        result: stream in, words of the core.
        taxel_forces: in, a frame that begins has the forces at the taxels.
        time: in, counts cycles.
        o: stream out.
        done: out, a pulse: the last word of a frame is taken from the core.
        saturated: out, with ``done``: a taxel or a result was.
        limited: out, with ``done``: as the core's status says.
        cycles: out, with ``done``: since the frame's first taxel.
        frames: out, frames are in the core, or their results in the unit.
    """

    def __init__(self, design: Design, flags: dict[str, int]) -> None:
        if design.word_bits > BITS:
            raise ValueError(f"formats: a result word of at most {BITS} bits fits the output, got {design.word_bits}")
        self._design, self._flags = design, flags
        super().__init__(
            {
                "facts": In(stream.Signature(FACTS)),
                "result": In(stream.Signature(result(design))),
                "taxel_forces": In(1),
                "time": In(BITS),
                "o": Out(stream.Signature(OUTPUT)),
                **dict.fromkeys(("done", "saturated", "limited", "frames"), Out(1)),
                "cycles": Out(BITS),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.queue = queue = PerFrameQueue(FACTS, (), FRAMES)
        m.d.comb += [queue.i.payload.eq(self.facts.payload), queue.i.valid.eq(self.facts.valid)]
        m.d.comb += self.facts.ready.eq(queue.i.ready)
        facts, beat, word = queue.o.payload, self.o.payload, self.result.payload
        sends = Signal(init=1)  # the word goes out
        ends = self.result.valid & self.result.ready & word.last
        with m.FSM():
            with m.State("NUMBER"):
                m.d.comb += [beat.data.eq(Cat(facts.sequence, facts.user)), self.o.valid.eq(queue.o.valid)]
                with m.If(self.o.valid & self.o.ready):
                    m.next = "FLAGS"
            with m.State("FLAGS"):
                m.d.comb += [beat.data.eq(self._second(facts.flags)), self.o.valid.eq(1)]
                with m.If(self.o.ready):
                    m.next = "WORDS"
            with m.State("WORDS"):
                m.d.comb += [
                    *(beat.data.eq(word.data.as_signed()), beat.last.eq(word.last)),
                    self.o.valid.eq(self.result.valid & sends),
                    self.result.ready.eq(self.o.ready | ~sends),
                    queue.o.ready.eq(ends),
                ]
                with m.If(ends):
                    m.next = "NUMBER"
        self._select(m, sends)
        self._tell(m, ends, facts)
        m.d.comb += self.frames.eq(queue.o.valid)
        return m

    def _second(self, flags: Any) -> Any:
        places: list[Any] = [Const(0, 1)] * (BITS - 8)
        for name, place in self._flags.items():
            places[place] = flags[name]
        return Cat(*places, Const(FORM, 8))

    def _select(self, m: Module, sends: Signal) -> None:
        """Follow the words of a frame; the forces are one run of them."""
        forces = next((field for field in self._design.layout if field.name == "forces"), None)
        if forces is None:
            return
        wanted = Signal(init=1, reset_less=True)
        number = Signal(counter_shape(self._design.frame_words - 1))
        taken = self.result.valid & self.result.ready
        following = Mux(self.result.payload.last, 0, number + 1)
        inside = (following >= forces.start) & (following < forces.start + forces.count)
        with m.If(taken):
            m.d.sync += [number.eq(following), sends.eq(wanted | ~inside)]
        with m.If((number == 0) & ~taken):
            m.d.sync += wanted.eq(self.taxel_forces)

    def _tell(self, m: Module, ends: Any, facts: Any) -> None:
        status = self.result.payload.data
        bits = [int(flag).bit_length() - 1 for flag in (Status.INPUT_SATURATED, Status.OUTPUT_SATURATED)]
        limited = Cat(status[bit] for bit in bits).any()
        m.d.comb += [
            self.done.eq(register(m, ends, "done", control=True)),
            self.limited.eq(register(m, ends & limited, "limited", control=True)),
            self.saturated.eq(register(m, ends & (limited | facts.flags.saturation), "saturated", control=True)),
            self.cycles.eq(register(m, self.time - facts.started, "cycles")),
        ]
