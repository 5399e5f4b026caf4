"""The sweep's input: quads of a frame become taxels (p, q, stress)."""

from collections.abc import Sequence
from typing import Any

from amaranth import Array, Cat, Const, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape, nth_slice
from tfra.hdl.lib.pipeline import READ, delayed, register, wrapping_counter
from tfra.hdl.lib.ram import Ram
from tfra.hdl.parallel import payloads
from tfra.model.fixed.butterfly import distinct
from tfra.model.fixed.design import Design

WORDS = 4
"""Words of a quad: cycles that a quad of e1 takes, one for each taxel."""
TURN = 4
"""Cycles from the last quad of e0 to the first of e1; the last quad has been counted when the first is."""

# Stages of a quad, in cycles after its transfer.
FOLDED = 5
"""Its words leave the butterfly."""
TAXEL = FOLDED + 1
"""Its first taxel is handed out."""
_READ_P = FOLDED - READ
"""Its p is read from the memory, so that it comes when q leaves the butterfly."""


def folded_taxel(design: Design) -> data.StructLayout:
    """One taxel after the butterfly, with its values from the frame's facts."""
    w = design.widths
    words = {"p": signed(w.vector), "q": signed(w.vector), "stress": signed(w.stress)}
    facts = {"negative": 1, "exponent": payloads.frame_facts(design)["exponent"].shape}
    return data.StructLayout({**words, **facts, "valid": 1})


class _Taken:
    """Times since quads of a vector were accepted."""

    def __init__(self, m: Module, pulse: Value, name: str) -> None:
        earlier = Signal(FOLDED + WORDS - 1, name=f"{name}_taken")
        m.d.sync += earlier.eq(Cat(pulse, earlier))
        self._ago = Cat(pulse, earlier)

    def at(self, stage: int) -> Value:
        """A quad was taken ``stage`` cycles ago."""
        return self._ago[stage]

    def during(self, stage: int, cycles: int) -> Value:
        """A quad is in ``stage``, or in one of the ``cycles - 1`` after it."""
        return self._ago[stage : stage + cycles].any()


class Loader(wiring.Component):
    """Send a frame's taxels, four cycles for each quad of e1.

    Quads of e0 are taken with g, one a cycle; those of e1 with stress, one in ``WORDS`` cycles, the first ``TURN``
    cycles after e0 at the earliest and a cycle after ``free`` and facts; e0 of the next frame ``WORDS`` cycles after
    e1.  Nothing waits for g and stress: they arrive before the quads that follow from them.

    The states, in separate registers, since the path from here to the queues' reads is long:

    ======= ============== ========= ================================== ==================================
    state   ``takes_e1``   ``word``  takes                              ends
    ======= ============== ========= ================================== ==================================
    e0      no             0         a quad of e0 in every cycle        with the last one: turn
    turn    yes            1, 2, 3   nothing                            in time: e1
    e1      yes            0         a quad of e1, once ``begun``       with it: pick
    pick    yes, or no     1, 2, 3   nothing; hands out words 1, 2, 3   in time: e1, or e0 after the last
            after the                                                   quad
            last quad
    ======= ============== ========= ================================== ==================================

    ``open_e0`` and ``open_e1`` are high in states e0 and e1.  ``begun`` is high from ``free`` and the facts until a
    frame's last quad has been taken.

    By cycles after the transfer of a quad of ``normal``:

    ====== ==============================================================================
    1      ``normal``, ``g``: what the queues gave
    2      ``vector``, ``offset``: the same, held until the next quad
    3      ``difference``: minus g in e0
    4      ``half``: first level of the butterfly
    5      ``FOLDED``: words after the butterfly.  Quads of e0 go to the memory of p, a beat a cycle.  Quads of e1 stay
           for four cycles, while p, q and stress are picked word by word
    6      ``TAXEL``: p, q and stress of a taxel; ``valid`` is low for a mirror taxel that is the same one as another
    ====== ==============================================================================

    Resources: 12 adders of the vector width, a memory of Q vector quads, a beat wide.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__({
            "stress": In(stream.Signature(payloads.stress_quad(design))),  # quads of stress
            "g": In(stream.Signature(vector)),  # quads of g, one for each of e0
            "normal": In(stream.Signature(vector)),  # quads of e0, then of e1
            # Fact of the frame, taken ``WORDS - 1`` cycles after the last quad of e1.
            "direction": In(stream.Signature(payloads.direction(design))),
            "frame": In(stream.Signature(payloads.frame_facts(design))),  # fact of the frame, taken with ``direction``
            "free": In(1),  # e1 of a frame may begin in the next cycle
            "begins": Out(1),  # the first quad of e1 is taken
            "ends": Out(1),  # the last quad of e1 is taken
            "taxel": Out(folded_taxel(design)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        word, took_e0, took_e1 = self._sequence(m)
        e0, e1 = _Taken(m, took_e0, "e0"), _Taken(m, took_e1, "e1")
        leaving = delayed(m, self.ends, WORDS - 1, "leaving", control=True)
        m.d.comb += [
            self.direction.ready.eq(leaving),
            self.frame.ready.eq(leaving),
            self.stress.ready.eq(e1.at(WORDS - 1)),
        ]
        folded = self._fold(m, e0, e1)
        number, _ = wrapping_counter(m, e0.at(FOLDED) | e1.at(FOLDED), self._design.quads, "folded_number")
        p = self._p(m, Cat(folded), number, word, e0, e1)
        self._taxels(m, p, folded, number, word, e1)
        return m

    def _sequence(self, m: Module) -> tuple[Signal, Value, Value]:
        """The states: number of the word that is picked of the quad taken last; quads of e0 and of e1 are taken."""
        takes_e1 = Signal()
        word = Signal(range(WORDS))
        took = Signal()
        number, last = wrapping_counter(m, took, self._design.quads)
        begun = self._begun(m)
        open_e0 = Signal(init=1)
        open_e1 = Signal()
        go_e1 = open_e1 & begun
        took_e0, took_e1 = open_e0 & self.normal.valid, go_e1 & self.normal.valid
        m.d.comb += [
            took.eq(took_e0 | took_e1),
            self.normal.ready.eq(open_e0 | go_e1),
            self.g.ready.eq(took_e0),
            self.begins.eq(took_e1 & (number == 0)),
            self.ends.eq(took_e1 & last),
        ]
        with m.If(took):
            m.d.sync += takes_e1.eq(takes_e1 ^ last)
        with m.If(took_e1):
            m.d.sync += word.eq(1)
        with m.Elif(took_e0 & last):
            m.d.sync += word.eq(WORDS - TURN + 1)
        with m.Elif(word != 0):
            m.d.sync += word.eq(word + 1)
        word_0_next = ~took_e1 & ~(took & last) & ((word == 0) | (word == WORDS - 1))
        # TIMING: takes_e1, word -> normal.ready
        m.d.sync += open_e0.eq(word_0_next & ~takes_e1)
        m.d.sync += open_e1.eq(word_0_next & takes_e1)
        return word, took_e0, took_e1

    def _begun(self, m: Module) -> Signal:
        """The frame's facts are there and the sums are free: e1 may begin."""
        begun = Signal()  # TIMING: free, facts -> normal.ready
        with m.If(register(m, self.ends, "ended", control=True)):
            m.d.sync += begun.eq(0)
        with m.Elif(self.free & self.direction.valid & self.frame.valid):
            m.d.sync += begun.eq(1)
        return begun

    def _fold(self, m: Module, e0: _Taken, e1: _Taken) -> list[Value]:
        """``butterfly(e0 - g)`` or ``butterfly(e1)`` modulo the word, which holds p and q by proof."""
        bits, quad = self._design.widths.vector, payloads.vector_quad(self._design)
        normal = register(m, self.normal.payload.as_value(), "normal")
        g = register(m, self.g.payload.as_value(), "g")
        is_e0 = register(m, e0.at(0), "is_e0", control=True)
        is_e1 = register(m, e1.at(0), "is_e1", control=True)
        vector = Signal(quad, reset_less=True)
        offset = Signal(quad, reset_less=True)
        minus_offset = Signal(reset_less=True)
        with m.If(is_e0 | is_e1):
            m.d.sync += vector.as_value().eq(normal)
            m.d.sync += offset.as_value().eq(g)
            m.d.sync += minus_offset.eq(is_e0)

        def word(value: Value, name: str) -> Value:
            return register(m, value[:bits].as_signed(), name)

        a, b, c, d = (word(vector[k] - Mux(minus_offset, offset[k], 0), f"difference{k}") for k in range(WORDS))
        plus_ab, minus_ab = word(a + b, "half_plus_ab"), word(a - b, "half_minus_ab")
        plus_cd, minus_cd = word(c + d, "half_plus_cd"), word(c - d, "half_minus_cd")
        folded = (plus_ab + plus_cd, minus_ab + minus_cd, plus_ab - plus_cd, minus_ab - minus_cd)
        return [word(value, f"folded{k}") for k, value in enumerate(folded)]

    def _p(self, m: Module, folded: Value, number: Value, word: Value, e0: _Taken, e1: _Taken) -> Value:
        """Memory of p, a beat wide: in stage ``FOLDED`` of e1 the p of the taxel beside its q.

        Words stand after the butterfly until the next quad comes, which is as many cycles as it has beats.
        """
        design, word_bits = self._design, (self._design.architecture.vector_words - 1).bit_length()
        beats, shape = design.cycles_per_quad, payloads.vector_beat(design)
        memory = Ram(m, "memory", shape, beats << len(number))
        stored = e0.during(FOLDED, beats)
        beat: Value = Const(0, 0)  # of the quad that is stored; one beat has no number
        if beats > 1:
            beat = Signal(counter_shape(beats - 1), name="beat")
            m.d.sync += beat.eq(Mux(stored, beat + 1, 0))
        read_word = delayed(m, word, _READ_P - 1, "read_word")
        read_number = self._latched(m, number, e1.at(_READ_P - 1), "read_number")
        stored_number = self._latched(m, number, e0.at(FOLDED), "stored_number")
        memory.write(stored, Cat(beat, stored_number), nth_slice(folded, beat, beats))
        read_address = register(m, Cat(read_word[word_bits:], read_number), "read_address")
        p = memory.read(read_address, e1.during(_READ_P, WORDS))
        beat_of_p = data.View(shape, register(m, p.as_value(), "beat_of_p"))
        if not word_bits:
            return beat_of_p[0]
        return Array(beat_of_p)[delayed(m, read_word[:word_bits], 1 + READ, "word_of_p")]

    def _taxels(self, m: Module, p: Value, q: list[Value], number: Value, word: Value, e1: _Taken) -> None:
        """Stage ``TAXEL`` of e1: one word after another of p, q and stress, with the facts of the frame."""
        taxel = Signal(self.taxel.shape(), reset_less=True)
        valid = Signal()
        m.d.comb += self.taxel.eq(taxel)
        m.d.comb += self.taxel.valid.eq(valid)
        distinct_words = self._distinct(m, number, e1.at(FOLDED - 1))
        quad = data.View(payloads.stress_quad(self._design), register(m, self.stress.payload.as_value(), "stress_quad"))
        stress = self._pick(quad, delayed(m, word, 1, "stress_word"))
        picked = delayed(m, word, FOLDED, "folded_word")
        m.d.sync += [
            taxel.p.eq(p),
            taxel.q.eq(self._pick(q, picked)),
            taxel.stress.eq(delayed(m, stress, FOLDED - 1, "stress")),
            taxel.negative.eq(delayed(m, self.direction.payload.negative, FOLDED, "negative")),
            taxel.exponent.eq(delayed(m, self.frame.payload.exponent, FOLDED, "exponent")),
            valid.eq(e1.during(FOLDED, WORDS) & distinct_words.bit_select(picked, 1)),
        ]

    def _distinct(self, m: Module, number: Value, load: Value) -> Signal:
        """The distinct taxels among the words of a quad, a bit each, from the static shape of the array."""
        words = Signal(WORDS, name="distinct_words", reset_less=True)
        with m.If(load), m.Switch(number):
            for at, row in enumerate(distinct(self._design)):
                with m.Case(at):
                    m.d.sync += words.eq(sum(1 << word for word in range(WORDS) if row[word]))
        return words

    @staticmethod
    def _latched(m: Module, value: Value, load: Value, name: str) -> Value:
        """``value`` in the cycle ``load``, and from then on."""
        latch = Signal.like(value, name=name, reset_less=True)
        with m.If(load):
            m.d.sync += latch.eq(value)
        return Mux(load, value, latch)

    @staticmethod
    def _pick(words: Sequence[Value] | data.View, number: Value) -> Value:
        """One of four words, by a multiplexer; indexing a view would infer a multiplier for the bit offset."""
        return Array(words[k] for k in range(WORDS))[number]
