"""Beats of sums into quads of vectors and of forces."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.beats import beat_in_quad
from tfra.hdl.parallel.payloads import operand, vector_beat, vector_quad
from tfra.hdl.parallel.tfra.combine.stages import Job, tag_layout
from tfra.model.fixed.design import Design


class Assembler(wiring.Component):
    """Quads, a cycle after their last beat; beats of a force's quad may come between those of a vector's."""

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "valid": In(1),  # a beat is there
            "tag": In(tag_layout(design)),  # that of the beat
            "sum": In(vector_beat(design)),  # its words
            "vector": Out(always_ready_stream(operand(design, "force"))),  # quads of e0, e1 and d
            "forces": Out(always_ready_stream(vector_quad(design))),  # quads of forces
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        is_force = self.tag.job == Job.FORCE
        whole = self.valid & (beat_in_quad(self._design, self.tag.number) == self._design.cycles_per_quad - 1)
        words = register(m, self._quad(m), "words")
        m.d.comb += [
            self.vector.valid.eq(register(m, whole & ~is_force, "vector_valid", control=True)),
            self.vector.payload.words.eq(words),
            self.vector.payload.force.eq(register(m, self.tag.job == Job.D, "is_d")),
            self.forces.valid.eq(register(m, whole & is_force, "forces_valid", control=True)),
            self.forces.payload.eq(words),
        ]
        return m

    def _quad(self, m: Module) -> Value:
        """The beat after those of its quad that came before it."""
        latest, is_force = self.sum.as_value(), self.tag.job == Job.FORCE
        if self._design.cycles_per_quad == 1:
            return latest
        earlier = {}
        for name, mine in (("vector", ~is_force), ("force", is_force)):
            beats = Signal((self._design.cycles_per_quad - 1) * len(latest), name=f"{name}_beats", reset_less=True)
            with m.If(self.valid & mine):
                m.d.sync += beats.eq(Cat(beats, latest)[len(latest) :])
            earlier[name] = beats
        return Cat(Mux(is_force, earlier["force"], earlier["vector"]), latest)
