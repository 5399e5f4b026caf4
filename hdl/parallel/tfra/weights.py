"""n = -w_z (Eq. 9): unfold C33^-1 b, keep the compressive part, fold again."""

from typing import Any

from amaranth import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import quad, round_negated
from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.pipeline import delayed, register, wrapping_counter
from tfra.hdl.lib.streams import always_ready_stream
from tfra.hdl.parallel.payloads import frame_facts, vector_quad
from tfra.model.fixed.design import Design


class Weights(wiring.Component):
    """Folded weights from the folded solution; the model is :func:`tfra.model.fixed.tfra.weights.weights`.

    ::

        solution -> Butterfly -> x -> round(-x / 4) -> max(., 0) if regular -> Butterfly -> register -> n

    Rounding and sign are one subtraction.  A taxel's n is two bits shorter than a vector word, by the bounds of
    :mod:`tfra.model.fixed.widths`.  Fully pipelined, one quad per cycle, and nothing waits; no multiplier, twenty
    adders.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__({
            "solution": In(always_ready_stream(vector_quad(design))),  # Q quads a frame, folded C33^-1 b
            # One transfer a frame, there before its first quad, taken when the last one has left the first
            # butterfly.
            "frame": In(stream.Signature(frame_facts(design))),
            "n": Out(always_ready_stream(vector_quad(design))),  # Q quads a frame, folded
        })
        self._unfold = Butterfly(design.widths.vector)
        self._fold = Butterfly(design.widths.vector - 2)

    @property
    def latency(self) -> int:
        """Cycles from the transfer of a quad of ``solution`` to that of the same quad of ``n``."""
        return self._unfold.latency + 2 + self._fold.latency + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.unfold, m.submodules.fold = unfold, fold = self._unfold, self._fold
        m.d.comb += [
            unfold.i.valid.eq(self.solution.valid),
            unfold.i.payload.eq(self.solution.payload),
            unfold.o.ready.eq(1),
            fold.o.ready.eq(1),
        ]
        self._clip(m)
        _, last = wrapping_counter(m, unfold.o.valid, self._design.quads, "quad")
        beats = self._design.cycles_per_quad
        m.d.comb += [
            # TIMING: second butterfly -> combine, matvec
            self.n.valid.eq(register(m, fold.o.valid, "n_valid", control=True)),
            self.n.payload.eq(register(m, fold.o.payload.as_value(), "n_words")),
            # Facts are held as long as the last quad.
            self.frame.ready.eq(delayed(m, unfold.o.valid & last, beats - 1, "last_quad", control=True)),
        ]
        return m

    def _clip(self, m: Module) -> None:
        """Two registers between the butterflies: subtraction, then clipping."""
        taxels = quad(self._design.widths.vector - 2)
        negated = Signal(taxels, reset_less=True)
        clipped = Signal(taxels, reset_less=True)
        regular = Signal(reset_less=True)
        facts = self.frame.payload
        m.d.sync += regular.eq(facts.contact & facts.traction)
        for k in range(4):
            m.d.sync += [
                negated[k].eq(round_negated(self._unfold.o.payload[k], 2)),
                clipped[k].eq(Mux(regular & (negated[k] < 0), 0, negated[k])),
            ]
        valid = delayed(m, self._unfold.o.valid, 2, "valid", control=True)
        m.d.comb += self._fold.i.valid.eq(valid)
        m.d.comb += self._fold.i.payload.eq(clipped)
