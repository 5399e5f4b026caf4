"""Normal forces at the taxels: bit-exact hardware of :func:`tfra.model.fixed.learned.field.field`."""

from typing import Any

from amaranth import Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.butterfly import Butterfly
from tfra.hdl.lib.pipeline import delayed, driver, occupancy, register, wrapping_counter
from tfra.hdl.lib.streams import TOKEN, always_ready_stream
from tfra.hdl.parallel.learned.payloads import contact, taxel_quad
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.hdl.parallel.learned.vectors import MEASURE, WORD, Vectors
from tfra.hdl.parallel.payloads import product
from tfra.hdl.parallel.scale_add import ScaleAdd, Stage
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.learned.field import MOST_FRICTION

_X = Stage.X_CHOSEN - WORD
"""Stage of a word whose s_x is addressed; that of s_y is a cycle later, so that its sum is, too."""
_STILL = Stage.Z - WORD
"""Stage of a word whose q0 is addressed."""
_TOTAL = Stage.SUM + 1
"""Stage of a word that has both products."""
_TAKEN = Stage.ROUNDED + 2
"""Stage of the last word in which no scalar is needed any more."""


class Field(wiring.Component):
    """p = max(0, butterfly(q0 + m_x s_x + m_y s_y)) of the taxels, from folded vectors, a word a cycle.

    ::

        q0  -> memory ------------> + -------------------> + -> four words -> Butterfly -> max(0, .) -> p
        s_x -> memory -> ScaleAdd --'                      |
        s_y -> memory -> ScaleAdd, a cycle after the other-'

    A frame begins when its contact, its vectors and a token are there, and the one before has entered.  Memories have a
    place for each frame in flight.  Resources: two multipliers, four barrel shifters, 12 adders.
    """

    def __init__(self, design: LearnedDesign) -> None:
        self._design, self._unfold = design, Butterfly(design.widths.force)
        super().__init__({
            # Results of all products; those of ``inverse``, ``shear_x`` and ``shear_y`` are looked at.
            "result": In(always_ready_stream(product(design))),
            # Fact of the frame; its friction is limited to ``MOST_FRICTION`` here.
            "contact": In(stream.Signature(contact(design))),
            "share_token": In(stream.Signature(TOKEN)),  # one taken at the beginning of each frame
            "p": Out(always_ready_stream(taxel_quad(design))),  # q quads of mirror taxels a frame, four cycles apart
        })

    vectors_latency = MEASURE
    """Cycles from the transfer of a frame's last product to the first one in which it may begin."""

    @property
    def latency(self) -> int:
        """Cycles from the one in which a frame begins to the transfer of its last quad of p: entry of all words, sums,
        a quad of them, the butterfly, the limit."""
        return 4 * self._design.quads + _TOTAL + 1 + self._unfold.latency + 1

    @property
    def interval(self) -> int:
        """Cycles from the beginning of a frame to the first in which the next one may begin."""
        return 4 * self._design.quads + _TAKEN + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        still, *sheared = (self._vectors(m, name) for name in ("inverse", "shear_x", "shear_y"))
        running, number, place = self._run(m, sheared[1].complete)
        sums: list[Value] = [still.word]
        bits = self._design.widths.force
        for late, axis in enumerate("xy"):
            m.submodules[f"add_{axis}"] = add = ScaleAdd(self._design, 1, bits)
            m.d.comb += [
                add.x[0].eq(sheared[late].word),
                add.headroom[0].eq(sheared[late].headroom),
                add.scalar.eq(register(m, self._limited(self.contact.p[f"mu_{axis}"]), f"m_{axis}")),
                add.z[0].eq(sums[-1]),
            ]
            sums.append(add.sum[0])
        for vectors, stage in zip((*sheared, still), (_X, _X + 1, _STILL), strict=True):
            address = delayed(m, number, stage, "address")
            m.d.comb += vectors.parity.eq(address[:2])
            m.d.comb += vectors.quad.eq(address[2:])
            m.d.comb += vectors.place.eq(place)
        self._unfold_sums(m, delayed(m, running, _TOTAL, "summed", control=True), sums[-1])
        return m

    def _vectors(self, m: Module, name: str) -> Vectors:
        """Memory of the results of an operator."""
        write = always_ready_stream(taxel_quad(self._design)).create(path=(name,))
        selected = self.result.valid & self.result.p.kind[self._design.kinds.index(name)]
        m.d.comb += write.valid.eq(selected)
        m.d.comb += (into.eq(word) for into, word in zip(write.p, self.result.p.words, strict=True))
        return Vectors(m, self._design, write, name, headroom=name != "inverse")

    def _run(self, m: Module, complete: Value) -> tuple[Signal, Signal, Signal]:
        """Words enter while the first is high; number of the word, and the place of its frame."""
        idle = Signal(init=1)
        running = Signal()
        begin = Signal()
        number, last = wrapping_counter(m, running, 4 * self._design.quads, "word")
        taken = delayed(m, running & last, _TAKEN, "taken", control=True)
        place, _ = wrapping_counter(m, taken, FRAMES, "place")
        waiting = occupancy(m, FRAMES, complete, begin)
        m.d.comb += [
            begin.eq(idle & waiting[0] & self.contact.valid & self.share_token.valid),
            self.share_token.ready.eq(begin),
            self.contact.ready.eq(taken),
        ]
        m.d.sync += idle.eq((idle & ~begin) | taken)
        m.d.sync += running.eq(begin | (running & ~last))
        return running, number, place

    def _limited(self, scalar: Value) -> Value:
        """The friction that the field may have."""
        most = int(MOST_FRICTION * 2 ** scalar_fraction(self._design))
        return Mux(scalar > most, most, Mux(scalar < -most, Const(-most, scalar.shape()), scalar)).as_signed()

    def _unfold_sums(self, m: Module, valid: Value, word: Value) -> None:
        """Four words to a quad, back to the taxels, and no tension."""
        m.submodules.unfold = unfold = self._unfold
        bits = self._design.widths.force
        words = Signal(4 * bits, reset_less=True)
        with m.If(valid):
            m.d.sync += words.eq(Cat(words, word)[bits:])
        _, ends = wrapping_counter(m, valid, 4, "parity")
        p = driver(m, self.p.payload)
        m.d.comb += [
            unfold.i.valid.eq(register(m, valid & ends, "quad_valid", control=True)),
            unfold.i.payload.eq(words),
            unfold.o.ready.eq(1),
            self.p.valid.eq(register(m, unfold.o.valid, "p_valid", control=True)),
        ]
        m.d.sync += (into.eq(Mux(word[-1], 0, word[: bits - 1])) for into, word in zip(p, unfold.o.p, strict=True))
