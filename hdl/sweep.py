"""The exact sweep of mu_ind: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

    stress ---------------------------------.
    g ------------- memory --.              |
    normal (e0) -- butterfly(e0 - g) = p ---+-- Loader: one taxel (p, q, stress) a cycle
    normal (e1) -- butterfly(e1)     = q ---'      |
                                                   v
          .-- x + P q, q, stress <-- memory -- Passes: x = K (p - [negative] q)   one pass per P candidates
          '----------------------------------------|
                                                   v
                      Lanes: x + c q for c = 0 ... P - 1, sums of max(0, .)
                                                   |  a row of P pairs (B^z, S - M) per pass
                                                   v
                      Judge: comparator tree, first over B^z, then over |S - M| = B^xy -- index

No multiplier is used: constant factors are additions of shifted words.
"""

from __future__ import annotations

from typing import Any

from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.pipeline import product_latency
from tfra.hdl.sweep_judge import Judge, judge_latency
from tfra.hdl.sweep_lanes import Lanes, lanes_latency
from tfra.hdl.sweep_loader import FOLDED, PLACES, Loader
from tfra.hdl.sweep_passes import Passes, pass_interval
from tfra.model.design import Design


class Sweep(wiring.Component):
    """``index`` of the candidate with the smallest B^xy on the plateau of B^z; equal to the model's ``sweep``.

    Takes one frame at a time: stress, g and normal in this order, then nothing until the index is taken.  Stress, g
    and e0 pass at a quad a cycle; quads of e1 at one in ``quad_interval`` cycles, the first of them two cycles
    behind e0 at the earliest, since the first pass runs while they come.  Quads of e0 wait until direction and
    frame are valid; both are taken when the index is found.

    Resources: no multiplier; per lane five adders or comparators, about 300 4-input tables at 46 bits; memories of
    Q vector quads, Q stress quads and, with several passes, m + 1 taxels and the sums of all candidates.

    Members:
        stress: Q taxel-domain quads of the normalised frame.
        g: Q parity-domain quads of C33 n.
        normal: 2 Q parity-domain quads of C33 A3-dagger e, those of e0, then those of e1.
        direction: ``negative`` is looked at.
        frame: ``exponent`` is looked at.
        index: the winner, one transfer a frame.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__(
            {
                "stress": In(stream.Signature(payloads.stress_quad(design))),
                "g": In(stream.Signature(vector)),
                "normal": In(stream.Signature(vector)),
                "direction": In(stream.Signature(payloads.direction(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "index": Out(stream.Signature(payloads.sweep_index(design))),
            }
        )

    @property
    def quad_interval(self) -> int:
        """Cycles between two quads of e1 at the shortest."""
        return PLACES

    @property
    def latency(self) -> int:
        """Cycles from the transfer of the frame's last normal quad (the 2Q-th) to the transfer of the index.

        With D = ceil(log2 P), k levels of the product by K (:func:`product_latency`), R passes and s = 1 if there
        is a tolerance, else 0: ``18 + k + max(D, k) + (R - 1) * pass_interval + 2 D + s + 2 R``.
        """
        to_taxel = FOLDED + PLACES + 1  # measured sum behind the last word
        to_lanes = 2 + product_latency(self._design.search.steps)
        again = (self._design.sweep_passes - 1) * pass_interval(self._design)
        return to_taxel + to_lanes + lanes_latency(self._design) + 1 + again + judge_latency(self._design)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.loader = loader = Loader(self._design)
        m.submodules.passes = passes = Passes(self._design)
        m.submodules.lanes = lanes = Lanes(self._design)
        m.submodules.judge = judge = Judge(self._design)
        for name in ("stress", "g", "normal"):
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(loader, name))
        m.d.comb += [
            loader.known.eq(self.direction.valid & self.frame.valid),
            loader.done.eq(self.index.valid & self.index.ready),
            passes.i.eq(loader.taxel),
            passes.negative.eq(self.direction.payload.negative),
            passes.idle.eq(loader.idle),
            lanes.i.eq(passes.o),
            # A single row stays in the lanes until it is judged.
            lanes.clear.eq(loader.idle | (judge.stands if self._design.sweep_passes > 1 else 0)),
            judge.ended.eq(lanes.ended),
            judge.idle.eq(loader.idle),
            judge.exponent.eq(self.frame.payload.exponent),
            self.direction.ready.eq(judge.found),
            self.frame.ready.eq(judge.found),
            self.index.payload.eq(judge.index),
        ]
        for lane in range(self._design.architecture.sweep_lanes):
            m.d.comb += [judge.z[lane].eq(lanes.z[lane]), judge.xy[lane].eq(lanes.xy[lane])]
        with m.If(judge.found):
            m.d.sync += self.index.valid.eq(1)
        with m.Elif(self.index.ready):
            m.d.sync += self.index.valid.eq(0)
        return m
