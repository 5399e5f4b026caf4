"""The exact sweep of mu_ind: B^z and B^xy of every candidate, and the choice between them (Eqs. 23-27).

    stress, g -- queues --.
    normal (e0) -- queue -+- butterfly(e0 - g) = p -- memory --.
    normal (e1) -- queue --- butterfly(e1)     = q ------------+-- Loader: one taxel (p, q, stress) a cycle
                                                   |
                                                   v
                         Terms: x = K (p - [negative] q), y = K b - x
                                   |                       |
                                   v                       v
                 Sums of max(0, x + k q) = B^z    Sums of max(0, y - k q) = S      one candidate k a cycle, or two
                                   |                       |
                                   v                       v
                 Judge: smallest B^z so far, then smallest |S - M| = B^xy on its plateau -- index

A frame takes m + K cycles or m + K / 2, not m K: see :class:`tfra.hdl.parallel.tfra.sweep.sums.Sums`.  No multiplier is
used: constant factors are additions of shifted words.
"""

from __future__ import annotations

from typing import Any

from amaranth import Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFO
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.streams import Buffer, Queue, always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.beats import beat_valid
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.sweep.judge import Judge, judge_latency
from tfra.hdl.parallel.tfra.sweep.loader import TURN, WORDS, Loader
from tfra.hdl.parallel.tfra.sweep.sums import Sums, first_row, rows, sums_wait
from tfra.hdl.parallel.tfra.sweep.terms import Terms, term, terms_latency
from tfra.model.fixed.design import Design

_FRAMES = 4
"""Frames on their way from the first quad of q to an index that is taken: terms, sums, judge and one to wait."""

_WAITING = {"stress": FRAMES + 1, "g": FRAMES, "normal": 2 * FRAMES}
"""Vectors that may wait: those of all frames in flight, so that the products never do; of stress one more, that of
the operand which is next."""
_FOLDED = 3
"""Quads behind that operand: two in the fold, and one that the fork offers it, which is here already.  So the
normaliser waits for the fold alone, and for the sweep never."""


class Sweep(wiring.Component):
    """``index`` of the candidate with the smallest B^xy on the plateau of B^z; equal to the model's ``sweep``.

    Takes frames back to back: stress, g and normal wait in queues, direction and frame in a buffer each.  A quad of
    e0 enters with its g; quads of e1 enter with stress, facts being there.  Entries (``Queue.latency`` cycles behind
    their transfers at the earliest) are apart at least

        between quads of e0                                  ``e0_interval``
        from the last of e0 to the first of e1               ``turn``
        between quads of e1                                  ``quad_interval``
        from the last of e1 to e0 of the next frame          ``quad_interval``
        from the last of e1 to e1 of the next frame          ``frame_interval``

    After a reset, the first quad of e1 waits for ``frame_interval`` cycles, in which the memories are cleared.

    Resources: no multiplier; two dividers without feedback; memories of 5 Q vector quads, 2 Q stress quads and
    2 K entries of the sums; with a tolerance the sums of all candidates.

    Members:
        stress: Q taxel-domain quads of the normalised frame, there before its normal ones; with a place for
            ``FRAMES + 1`` frames that have not been swept, and for three quads more.
        g: Q parity-domain quads of C33 n, there before those of e0, which follow from it.
        normal: 2 Q parity-domain quads of C33 A3-dagger e, those of e0, then those of e1.  Both have a place for
            ``FRAMES`` frames whose index has not been taken.
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
                "g": In(always_ready_stream(vector)),
                "normal": In(always_ready_stream(vector)),
                "direction": In(stream.Signature(payloads.direction(design))),
                "frame": In(stream.Signature(payloads.frame_facts(design))),
                "index": Out(stream.Signature(payloads.sweep_index(design))),
            }
        )

    @property
    def turn(self) -> int:
        """Cycles from the last quad of e0 to the first of e1 at the shortest."""
        return max(TURN, self.e0_interval)

    @property
    def e0_interval(self) -> int:
        """Cycles between two quads of e0 at the shortest."""
        return self._design.cycles_per_quad

    @property
    def quad_interval(self) -> int:
        """Cycles between two quads of e1 at the shortest."""
        return WORDS

    @property
    def frame_interval(self) -> int:
        """Cycles from a frame's last quad of e1 to the first of the next frame at the shortest."""
        return WORDS - 1 + sums_wait(self._design)

    @property
    def interval(self) -> int:
        """Cycles per frame while all inputs are always there and the index is always taken."""
        steps = self._design.quads - 1
        return WORDS * steps + max(self.frame_interval, WORDS + self.e0_interval * steps + self.turn)

    @property
    def latency(self) -> int:
        """Cycles from the last part of the frame's last normal quad (the 2Q-th) to the transfer of the index.

        The unit waits for this quad, that is, the quads before it have entered as early as they may.  With k levels
        of the product by K (:func:`product_latency`) and Z quotient bits: ``28 + k + Z + K``, and ``K + 3`` more with a
        tolerance; for two candidates a cycle ``floor(K / 2) + 5`` instead of K, and ``floor(K / 2) + 5`` more.
        """
        design = self._design
        last_row = first_row(design) + rows(design) - 1
        return Queue.latency + terms_latency(design) + last_row + judge_latency(design) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.loader = loader = Loader(self._design)
        m.submodules.terms = terms = Terms(self._design)
        m.submodules.judge = judge = Judge(self._design)
        words, w = term(self._design), self._design.widths
        m.submodules.z = z = Sums(self._design, words["x"].width, w.b_z)
        m.submodules.xy = xy = Sums(self._design, words["y"].width, w.b_xy)
        self._wait(m, loader)
        m.d.comb += [
            loader.free.eq(self._free(m, loader)),
            terms.i.eq(loader.taxel),
            terms.ends.eq(loader.ends),
            z.first.eq(terms.o.x),
            z.step.eq(terms.o.q),
            z.size.eq(terms.o.size),
            xy.first.eq(terms.o.y),
            xy.step.eq(terms.o.r),
            xy.size.eq(terms.o.size),
            *(row.z.eq(value) for row, value in zip(judge.rows, z.sums, strict=True)),
            *(row.xy.eq(value) for row, value in zip(judge.rows, xy.sums, strict=True)),
            judge.valid.eq(z.valid),
        ]
        for sums in (z, xy):
            m.d.comb += [sums.i_valid.eq(terms.valid), sums.ended.eq(terms.ended)]
        with m.If(z.begins):  # what the judge looks at stands until it has seen all candidates
            m.d.sync += [judge.measured.eq(terms.measured), judge.exponent.eq(terms.exponent)]
        m.submodules.indices = indices = SyncFIFO(width=len(judge.index), depth=_FRAMES)
        m.d.comb += [
            indices.w_data.eq(judge.index),
            indices.w_en.eq(judge.found),
            self.index.payload.eq(indices.r_data),
            self.index.valid.eq(indices.r_rdy),
            indices.r_en.eq(self.index.ready),
        ]
        return m

    def _wait(self, m: Module, loader: Loader) -> None:
        """What comes before the loader needs it."""
        for name, vectors in _WAITING.items():
            port = getattr(self, name)
            parts = 1 if name == "stress" else self._design.cycles_per_quad
            m.submodules[name] = wait = Queue(port.payload.shape(), vectors * self._design.quads + _FOLDED, parts)
            wiring.connect(m, wait.o, getattr(loader, name))
            if name == "stress":
                wiring.connect(m, wiring.flipped(port), wait.i)
            else:
                valid = beat_valid(m, port.valid, wait.i.ready)
                m.d.comb += [wait.i.valid.eq(valid), wait.i.payload.eq(port.payload)]
        for name in ("direction", "frame"):
            port = getattr(self, name)
            m.submodules[name] = fact = Buffer(port.payload.shape())
            wiring.connect(m, wiring.flipped(port), fact.i)
            wiring.connect(m, fact.o, getattr(loader, name))

    def _free(self, m: Module, loader: Loader) -> Value:
        """The sums of the frame before leave room for another, and there is a place for its index."""
        wait = Signal(range(self.frame_interval), init=self.frame_interval - 2)
        frames = Signal(counter_shape(_FRAMES))
        begins, ends = (register(m, pulse, control=True) for pulse in (loader.begins, loader.ends))
        with m.If(ends):
            m.d.sync += wait.eq(self.frame_interval - 3)  # the loader begins a cycle later
        with m.Elif(wait != 0):
            m.d.sync += wait.eq(wait - 1)
        m.d.sync += frames.eq(frames + begins - (self.index.valid & self.index.ready))
        return (wait == 0) & (frames != _FRAMES)
