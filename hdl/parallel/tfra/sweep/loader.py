"""The sweep's way in: quads of a frame become taxels (p, q, stress)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, nth_part
from tfra.hdl.lib.pipeline import READ, delayed, register, wrapping_counter
from tfra.hdl.parallel import payloads
from tfra.model.fixed.butterfly import distinct
from tfra.model.fixed.design import Design

PLACES = 4
"""Cycles a quad of q takes: one per word."""
TURN = 4
"""Cycles from the last quad of e0 to the first of e1; the last quad has been counted when the first is."""
FOLDED = 5
"""Cycles from a quad's transfer to its words behind the butterfly."""
TAXEL = FOLDED + 1
"""Cycles from a quad's transfer to its first taxel."""
_READ = FOLDED - READ
"""Cycles from a quad's transfer to the read of its p, with an address from a register."""


def folded_taxel(design: Design) -> data.StructLayout:
    """One taxel behind the butterfly with what its frame's facts say of it."""
    w = design.widths
    words = {"p": signed(w.vector), "q": signed(w.vector), "stress": signed(w.stress)}
    facts = {"negative": 1, "exponent": payloads.frame_facts(design)["exponent"].shape}
    return data.StructLayout({**words, **facts, "valid": 1})


class Loader(wiring.Component):
    """Hand out a frame's taxels, four cycles for each quad of e1.

    Dataflow of ``normal``, by cycles behind the transfer: 1, 2 held with g, 3 minus g, 4, 5 butterfly.  Quads of e0
    then go to the memory of p.  Quads of e1 stay for four cycles, while p, q and stress are picked word by word;
    words of mirror taxels that are the same one are left out (``valid`` is low).

    Quads of e0 are taken with g, one a cycle; those of e1 with stress, one in ``PLACES`` cycles, the first ``TURN``
    cycles behind e0 at the earliest and a cycle behind ``free`` and facts; e0 of the next frame ``PLACES`` cycles
    behind e1.  Nothing waits for g and stress: what they lead to comes later.

    Resources: 12 adders of the vector width, a memory of Q vector quads, a part wide.
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
                "free": In(1),  # e1 of a frame may begin in the next cycle
                "begins": Out(1),  # the first quad of e1 is taken
                "ends": Out(1),  # the last quad of e1 is taken
                "taxel": Out(folded_taxel(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        sloping, place, took = Signal(), Signal(range(PLACES)), Signal()
        number, last = wrapping_counter(m, took, self._design.quads)
        begun = Signal()  # a register, since the way from here to the queues' reads is long
        ended = register(m, self.ends, "ended", control=True)
        with m.If(ended):
            m.d.sync += begun.eq(0)
        with m.Elif(self.free & self.direction.valid & self.frame.valid):
            m.d.sync += begun.eq(1)
        open_e0, open_e1 = Signal(init=1), Signal()  # place is zero, and a quad of e0 is next, or of e1
        go_e1 = open_e1 & begun
        took_e0, took_e1 = open_e0 & self.normal.valid, go_e1 & self.normal.valid
        still = ~took_e1 & ~(took & last) & ((place == 0) | (place == PLACES - 1))
        m.d.sync += [open_e0.eq(still & ~sloping), open_e1.eq(still & sloping)]
        m.d.comb += [
            took.eq(took_e0 | took_e1),
            self.normal.ready.eq(open_e0 | go_e1),
            self.g.ready.eq(took_e0),
            self.begins.eq(took_e1 & (number == 0)),
            self.ends.eq(took_e1 & last),
        ]
        with m.If(took):
            m.d.sync += sloping.eq(sloping ^ last)
        with m.If(took_e1):
            m.d.sync += place.eq(1)
        with m.Elif(took_e0 & last):
            m.d.sync += place.eq(PLACES - TURN + 1)
        with m.Elif(place != 0):
            m.d.sync += place.eq(place + 1)
        leaving = delayed(m, self.ends, PLACES - 1, control=True)
        m.d.comb += [self.direction.ready.eq(leaving), self.frame.ready.eq(leaving)]
        self._taxels(m, place, self._later(m, took_e0), self._later(m, took_e1))
        return m

    def _taxels(self, m: Module, place: Value, e0: Value, e1: Value) -> None:
        """Memory of p and the picking; bit k of ``e0`` and ``e1``: such a quad was taken k cycles ago."""
        i, words = Signal(self.taxel.shape(), reset_less=True), self._butterfly(m, e0[0], e1[0])
        # What leaves the butterfly next.
        behind, _ = wrapping_counter(m, e0[FOLDED] | e1[FOLDED], self._design.quads, "behind")
        valid = Signal()
        m.d.comb += [self.stress.ready.eq(e1[PLACES - 1]), self.taxel.eq(i), self.taxel.valid.eq(valid)]
        keep = self._keep(m, behind, e1[FOLDED - 1])
        stress = data.View(payloads.stress_quad(self._design), delayed(m, self.stress.payload.as_value(), 1))
        picked = delayed(m, place, FOLDED)
        m.d.sync += [
            i.p.eq(self._p(m, Cat(words), behind, place, e0, e1)),
            i.q.eq(self._pick(words, picked)),
            i.stress.eq(delayed(m, self._pick(stress, delayed(m, place, 1)), FOLDED - 1)),
            i.negative.eq(delayed(m, self.direction.payload.negative, FOLDED)),
            i.exponent.eq(delayed(m, self.frame.payload.exponent, FOLDED)),
            valid.eq(e1[FOLDED : FOLDED + PLACES].any() & keep.bit_select(picked, 1)),
        ]

    def _p(self, m: Module, words: Value, behind: Value, place: Value, e0: Value, e1: Value) -> Value:
        """Memory of p, a part wide: the p of the taxel beside the butterfly.

        Words stand behind the butterfly until the next quad comes, which is as many cycles as it has parts.
        """
        design, inside = self._design, (self._design.architecture.vector_words - 1).bit_length()
        shape = payloads.vector_beat(design)
        m.submodules.memory = memory = Memory(shape=shape, depth=design.cycles_per_quad << len(behind), init=[])
        write, read = memory.write_port(), memory.read_port()
        # Of the quad that leaves the butterfly; words without bits would not be portable Verilog.
        part = Signal(counter_shape(design.cycles_per_quad - 1)) if design.cycles_per_quad > 1 else Const(0, 0)
        stored = e0[FOLDED : FOLDED + design.cycles_per_quad].any()
        later = delayed(m, place, _READ - 1)
        if design.cycles_per_quad > 1:
            m.d.sync += part.eq(Mux(stored, part + 1, 0))
        m.d.comb += [
            write.addr.eq(Cat(part, self._kept(m, behind, e0[FOLDED]))),
            write.data.eq(nth_part(words, part, design.cycles_per_quad)),
            write.en.eq(stored),
            read.addr.eq(register(m, Cat(later[inside:], self._kept(m, behind, e1[_READ - 1])))),
            read.en.eq(e1[_READ : _READ + PLACES].any()),
        ]
        found = data.View(shape, delayed(m, read.data.as_value(), 1))
        return Array(found)[delayed(m, later[:inside], 1 + READ)] if inside else found[0]

    @staticmethod
    def _kept(m: Module, value: Value, when: Value) -> Value:
        """``value`` of the cycle ``when``, and behind it."""
        kept = Signal.like(value, reset_less=True)
        with m.If(when):
            m.d.sync += kept.eq(value)
        return Mux(when, value, kept)

    @staticmethod
    def _pick(words: Sequence[Value] | data.View, place: Value) -> Value:
        """One of four words: a multiplexer, where indexing a view would take a multiplier for the bit's place."""
        return Array(words[k] for k in range(PLACES))[place]

    @staticmethod
    def _later(m: Module, pulse: Value) -> Value:
        """Bit k: ``pulse`` of k cycles ago."""
        seen = Signal(FOLDED + PLACES - 1)
        m.d.sync += seen.eq(Cat(pulse, seen))
        return Cat(pulse, seen)

    def _butterfly(self, m: Module, took_e0: Value, took_e1: Value) -> list[Value]:
        """``butterfly(e0 - g)`` or ``butterfly(e1)`` modulo the word, which holds p and q by proof."""
        bits = self._design.widths.vector
        vector = Signal(payloads.vector_quad(self._design), reset_less=True)
        offset = Signal(payloads.vector_quad(self._design), reset_less=True)
        curved = Signal(reset_less=True)
        normal, g = register(m, self.normal.payload.as_value()), register(m, self.g.payload.as_value())
        e0, e1 = register(m, took_e0, control=True), register(m, took_e1, control=True)
        with m.If(e0 | e1):
            m.d.sync += [vector.as_value().eq(normal), offset.as_value().eq(g), curved.eq(e0)]

        def word(value: Value) -> Value:
            return register(m, value[:bits].as_signed())

        a, b, c, d = (word(vector[k] - Mux(curved, offset[k], 0)) for k in range(4))
        plus, minus, plus2, minus2 = word(a + b), word(a - b), word(c + d), word(c - d)
        return [word(v) for v in (plus + plus2, minus + minus2, plus - plus2, minus - minus2)]

    def _keep(self, m: Module, number: Value, look: Value) -> Signal:
        """Which words of a quad are taxels of their own: a bit each, from the static shape of the array."""
        keep = Signal(PLACES, reset_less=True)
        with m.If(look), m.Switch(number):
            for at, row in enumerate(distinct(self._design)):
                with m.Case(at):
                    m.d.sync += keep.eq(sum(1 << place for place in range(PLACES) if row[place]))
        return keep
