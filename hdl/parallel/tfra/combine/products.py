"""Beats of the force products, A-dagger d, and the scalars of their forces."""

from typing import Any

from amaranth import Array, C, Module, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.pipeline import register, wrapping_counter
from tfra.hdl.lib.streams import SkidBuffer, always_ready_stream
from tfra.hdl.parallel.beats import beat_number, select_beat, vector_beats
from tfra.hdl.parallel.payloads import chosen, vector_beat, vector_quad
from tfra.hdl.parallel.tfra.combine.store import FRAMES, place
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction


class ProductBeats(wiring.Component):
    """Products enter the pipeline in the cycles in which they arrive."""

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            # 3 Q quads a frame, after its ``forced``: A1-dagger d, A2-dagger d, A3-dagger d.
            "products": In(always_ready_stream(vector_quad(design))),
            # One transfer a frame, taken when the last products of the frame before have entered.
            "forced": In(stream.Signature(chosen(design))),
            "valid": Out(1),  # a beat enters
            "words": Out(vector_beat(design)),  # the beat
            "place": Out(place),  # that of its frame
            "number": Out(beat_number(design)),  # its number in its product
            # One of mu_x, mu_y and -1: that of the beat that entered a cycle ago.
            "scalar": Out(signed(design.formats.bits("scalar"))),
            "frame_done": Out(1),  # pulse, a cycle after the entry of a frame's last beat
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        m.submodules.forced = forced = SkidBuffer(self.forced.payload.shape())
        wiring.connect(m, wiring.flipped(self.forced), forced.i)
        valid, number, ends = vector_beats(m, design, self.products.valid)
        plane, _ = wrapping_counter(m, ends, 3, "plane")
        _, last = wrapping_counter(m, valid, 3 * design.quads * design.cycles_per_quad, "beat_in_frame")
        frame_ends = valid & last
        frame_place, _ = wrapping_counter(m, frame_ends, FRAMES, "place")
        minus_one = C(-1 << scalar_fraction(design), signed(design.formats.bits("scalar")))
        facts = forced.o.payload
        # TIMING: matvec's result router -> queue of facts, scalar of a beat
        entered_last = register(m, frame_ends, "entered_last", control=True)
        entered_plane = register(m, plane, "entered_plane")
        m.d.comb += [
            self.valid.eq(valid),
            self.words.eq(select_beat(design, self.products.payload, number)),
            self.place.eq(frame_place),
            self.number.eq(number),
            self.scalar.eq(Array([facts.mu_x, facts.mu_y, minus_one])[entered_plane]),
            forced.o.ready.eq(entered_last),
            self.frame_done.eq(entered_last),
        ]
        return m
