"""n = -w_z (Eq. 9): unfold C33^-1 b, keep what presses, fold again."""

from __future__ import annotations

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.arithmetic import quad
from tfra.hdl.butterfly import Butterfly
from tfra.hdl.payloads import frame_facts, vector_quad
from tfra.hdl.pipeline import walk
from tfra.hdl.streams import Spare
from tfra.model.design import Design
from tfra.model.fixed.widths import widths


class Weights(wiring.Component):
    """Folded weights from the folded solution; the model is :func:`tfra.model.fixed.weights.weights`.

    ::

        solution -> Butterfly -> x -> (1 - x) >> 2 -> max(., 0) if regular -> Butterfly -> spare -> n

    ``-round_shift(x, 2)`` is ``(1 - x) >> 2``: rounding and sign are one subtraction.  A taxel's n is two bits
    shorter than a vector word, by the bounds of :mod:`tfra.model.fixed.widths`.  Fully pipelined, one quad per
    cycle; no multiplier, twenty adders.

    Members:
        solution: Q quads a frame, folded C33^-1 b.
        frame: one transfer a frame, taken with the last quad that leaves the first butterfly.
        n: Q quads a frame, folded.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "solution": In(stream.Signature(vector_quad(design))),
                "frame": In(stream.Signature(frame_facts(design))),
                "n": Out(stream.Signature(vector_quad(design))),
            }
        )
        self._unfold = Butterfly(widths(design).vector)
        self._fold = Butterfly(widths(design).vector - 2)

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a quad of ``solution`` to that of the same quad of ``n``; ``frame`` is valid."""
        return self._unfold.latency + 2 + self._fold.latency + Spare.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.unfold, m.submodules.fold = unfold, fold = self._unfold, self._fold
        wiring.connect(m, wiring.flipped(self.solution), unfold.i)
        m.submodules.spare = spare = Spare(vector_quad(self._design))
        wiring.connect(m, fold.o, spare.i)
        wiring.connect(m, spare.o, wiring.flipped(self.n))
        advance, enter = Signal(), Signal()
        m.d.comb += [
            advance.eq(spare.i.ready),
            unfold.o.ready.eq(~spare.used & self.frame.valid),
            enter.eq(unfold.o.valid & unfold.o.ready),
        ]
        self._clip(m, advance, enter)
        self._release(m, enter)
        return m

    def _clip(self, m: Module, advance: Signal, enter: Signal) -> None:
        """Two registers between the butterflies: subtraction, then clipping."""
        taxels = quad(widths(self._design).vector - 2)
        negated, clipped = Signal(taxels, reset_less=True), Signal(taxels, reset_less=True)
        regular = Signal(reset_less=True)
        negated_valid, clipped_valid = Signal(), Signal()
        facts = self.frame.payload
        with m.If(advance):
            m.d.sync += [
                negated_valid.eq(enter),
                clipped_valid.eq(negated_valid),
                regular.eq(facts.contact & facts.traction),
            ]
            for k in range(4):
                m.d.sync += [
                    negated[k].eq((1 - self._unfold.o.payload[k]) >> 2),
                    clipped[k].eq(Mux(regular & (negated[k] < 0), 0, negated[k])),
                ]
        m.d.comb += [self._fold.i.valid.eq(clipped_valid & advance), self._fold.i.payload.eq(clipped)]

    def _release(self, m: Module, enter: Signal) -> None:
        """Take the frame's facts with its last quad."""
        _, last = walk(m, enter, self._design.quads)
        m.d.comb += self.frame.ready.eq(enter & last)
