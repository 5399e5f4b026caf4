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
                 Winner: smallest B^z so far, then smallest |S - M| = B^xy on its plateau -- index

A frame takes m + K cycles or m + K / 2, not m K: see :class:`tfra.hdl.parallel.tfra.sweep.sums.Sums`.  No multiplier is
used: constant factors are additions of shifted words.
"""

from typing import Any

from amaranth import Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import SyncFIFO
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.streams import Buffer, Fifo, always_ready_stream
from tfra.hdl.parallel import payloads
from tfra.hdl.parallel.beats import beat_valid
from tfra.hdl.parallel.tfra.combine.store import FRAMES
from tfra.hdl.parallel.tfra.sweep.loader import TURN, WORDS, Loader
from tfra.hdl.parallel.tfra.sweep.sums import Sums, first_row, rows, sums_wait
from tfra.hdl.parallel.tfra.sweep.terms import Terms, term, terms_latency
from tfra.hdl.parallel.tfra.sweep.winner import Winner, winner_latency
from tfra.model.fixed.design import Design

_FRAMES = 4
"""Frames between the first quad of q and an index that is taken: in terms, sums and winner, and one that waits."""

_WAITING = {"stress": FRAMES + 1, "g": FRAMES, "normal": 2 * FRAMES}
"""Capacity of the queues in vectors.  The products never wait for a queue: each holds the vectors of all frames in
flight.  That of stress holds one more, the next operand of the products."""
_FOLDED = 3
"""Quads that follow this operand: two are in the fold, one is what the fork offers to the fold and has sent here.  So
the normaliser never waits for the sweep."""


class Sweep(wiring.Component):
    """``index`` of the candidate with the smallest B^xy on the plateau of B^z; equal to the model's ``sweep``.

    Takes frames back to back: stress, g and normal wait in queues, direction and frame in a buffer each.  A quad of
    e0 enters the loader with its g; quads of e1 enter it with stress, when the facts are valid.  They enter
    ``Fifo.latency`` cycles after their transfers at the earliest.  At least that many cycles lie

        between quads of e0                                  ``e0_interval``
        from the last of e0 to the first of e1               ``turn``
        between quads of e1                                  ``quad_interval``
        from the last of e1 to e0 of the next frame          ``quad_interval``
        from the last of e1 to e1 of the next frame          ``frame_interval``

    After a reset, the first quad of e1 waits for ``frame_interval`` cycles, in which the memories are cleared.

    Resources: no multiplier; two dividers without feedback; memories of 5 Q vector quads, 2 Q stress quads and
    2 K entries of the sums; with a tolerance the sums of all candidates.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__({
            # Q taxel-domain quads of the normalised frame, before its normal ones.  There is a place for those of
            # ``FRAMES + 1`` frames that have not been swept, and for three quads more.
            "stress": In(stream.Signature(payloads.stress_quad(design))),
            # Q parity-domain quads of C33 n, before those of e0, which follow from it.  There is a place for those
            # of ``FRAMES`` frames whose index has not been taken.
            "g": In(always_ready_stream(vector)),
            # 2 Q parity-domain quads of C33 A3-dagger e, those of e0, then those of e1; places as of g.
            "normal": In(always_ready_stream(vector)),
            "direction": In(stream.Signature(payloads.direction(design))),  # fact of the frame; ``negative`` is used
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame; ``exponent`` is used
            "index": Out(stream.Signature(payloads.sweep_index(design))),  # the winner, one transfer a frame
        })

    @property
    def turn(self) -> int:
        """Least number of cycles from the last quad of e0 to the first of e1."""
        return max(TURN, self.e0_interval)

    @property
    def e0_interval(self) -> int:
        """Least number of cycles between two quads of e0."""
        return self._design.cycles_per_quad

    @property
    def quad_interval(self) -> int:
        """Least number of cycles between two quads of e1."""
        return WORDS

    @property
    def frame_interval(self) -> int:
        """Least number of cycles from a frame's last quad of e1 to the first of the next frame."""
        return WORDS - 1 + sums_wait(self._design)

    @property
    def latency(self) -> int:
        """Cycles from the last part of the frame's last normal quad (the 2Q-th) to the transfer of the index.

        The unit waits for this quad: those before it have entered as early as they may.
        """
        design = self._design
        last_row = first_row(design) + rows(design) - 1
        return Fifo.latency + terms_latency(design) + last_row + winner_latency(design) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.loader = loader = Loader(self._design)
        m.submodules.terms = terms = Terms(self._design)
        m.submodules.winner = winner = Winner(self._design)
        words, w = term(self._design), self._design.widths
        m.submodules.z = z = Sums(self._design, words["x"].width, w.b_z)
        m.submodules.xy = xy = Sums(self._design, words["y"].width, w.b_xy)
        self._wait(m, loader)
        m.d.comb += [
            loader.free.eq(self._free(m, loader)),
            terms.i.eq(loader.taxel),
            terms.ends.eq(loader.ends),
        ]
        for sums, first, step in ((z, terms.o.x, terms.o.q), (xy, terms.o.y, terms.o.r)):
            m.d.comb += [
                sums.first.eq(first),
                sums.step.eq(step),
                sums.size.eq(terms.o.size),
                sums.i_valid.eq(terms.valid),
                sums.ended.eq(terms.ended),
            ]
        m.d.comb += winner.valid.eq(z.valid)  # those of xy come in the same cycles
        for row, b_z, b_xy in zip(winner.rows, z.sums, xy.sums, strict=True):
            m.d.comb += row.z.eq(b_z)
            m.d.comb += row.xy.eq(b_xy)
        with m.If(z.begins):  # they stay until all candidates have been compared
            m.d.sync += winner.measured.eq(terms.measured)
            m.d.sync += winner.exponent.eq(terms.exponent)
        self._send(m, winner)
        return m

    def _wait(self, m: Module, loader: Loader) -> None:
        """Queues and buffers for inputs that arrive before the loader needs them."""
        for name, vectors in _WAITING.items():
            port = getattr(self, name)
            beats = 1 if name == "stress" else self._design.cycles_per_quad
            m.submodules[name] = wait = Fifo(port.payload.shape(), vectors * self._design.quads + _FOLDED, beats)
            wiring.connect(m, wait.o, getattr(loader, name))
            if name == "stress":
                wiring.connect(m, wiring.flipped(port), wait.i)
            else:
                valid = beat_valid(m, port.valid, wait.i.ready)
                m.d.comb += wait.i.valid.eq(valid)
                m.d.comb += wait.i.payload.eq(port.payload)
        for name in ("direction", "frame"):
            port = getattr(self, name)
            m.submodules[name] = fact = Buffer(port.payload.shape())
            wiring.connect(m, wiring.flipped(port), fact.i)
            wiring.connect(m, fact.o, getattr(loader, name))

    def _free(self, m: Module, loader: Loader) -> Value:
        """The sums are free for another frame, and there is a place for its index."""
        wait = Signal(range(self.frame_interval), init=self.frame_interval - 2)  # cycles until the sums are free
        frames = Signal(counter_shape(_FRAMES))  # on their way to an index that is taken
        begins = register(m, loader.begins, "begins", control=True)
        ends = register(m, loader.ends, "ends", control=True)
        with m.If(ends):
            m.d.sync += wait.eq(self.frame_interval - 3)  # the loader begins a cycle later
        with m.Elif(wait != 0):
            m.d.sync += wait.eq(wait - 1)
        m.d.sync += frames.eq(frames + begins - (self.index.valid & self.index.ready))
        return (wait == 0) & (frames != _FRAMES)

    def _send(self, m: Module, winner: Winner) -> None:
        """Indices wait until they are taken.  The queue is never full: ``_free`` counts their places."""
        m.submodules.indices = indices = SyncFIFO(width=len(winner.index), depth=_FRAMES)
        m.d.comb += [
            indices.w_data.eq(winner.index),
            indices.w_en.eq(winner.found),
            self.index.payload.eq(indices.r_data),
            self.index.valid.eq(indices.r_rdy),
            indices.r_en.eq(self.index.ready),
        ]
