"""The sweep's way in: quads of a frame become taxels (p, q, stress)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amaranth import Array, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl import payloads
from tfra.hdl.arithmetic import count
from tfra.hdl.pipeline import delayed
from tfra.model.design import Design
from tfra.model.fixed.butterfly import distinct
from tfra.model.fixed.widths import widths

PLACES = 4
"""Cycles a quad of q takes: one per word."""
FOLDED = 5
"""Cycles from a quad's transfer to its words behind the butterfly."""
_READ = FOLDED - 1
"""Cycles from a quad's transfer to the read of its p and stress."""


def folded_taxel(design: Design) -> data.StructLayout:
    """One taxel behind the butterfly; ``measured`` marks the slot behind a frame's last one."""
    w = widths(design)
    words = {"p": signed(w.vector), "q": signed(w.vector), "stress": signed(w.stress)}
    return data.StructLayout({**words, "valid": 1, "measured": 1})


class Loader(wiring.Component):
    """Collect a frame's quads and hand out its taxels.

    Dataflow of ``normal``, by cycles behind the transfer: 1 held, 2 (g read and held), 3 minus g, 4 and 5
    butterfly.  Quads of e0 then go to the memory of g, which keeps p from here on.  Quads of e1 stay for four
    cycles, while p, q and stress are picked word by word; words of mirror taxels that are the same one are left
    out (``valid`` is low).  ``measured`` follows the last quad's last word.

    Resources: 12 adders of the vector width, memories of Q vector quads and Q stress quads.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        vector = payloads.vector_quad(design)
        super().__init__(
            {
                "stress": In(stream.Signature(payloads.stress_quad(design))),
                "g": In(stream.Signature(vector)),
                "normal": In(stream.Signature(vector)),
                "known": In(1),  # direction and exponent are there
                "done": In(1),  # the frame is over
                "idle": Out(1),  # no frame has begun to be swept
                "taxel": Out(folded_taxel(design)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        step, number, behind = Signal(range(5)), self._number(), self._number()
        in_stress, in_g, in_e0, in_e1 = (step == k for k in range(4))
        pause = Signal(range(PLACES))
        took_stress, took_g = self.stress.valid & in_stress, self.g.valid & in_g
        flow = (in_e0 & self.known) | (in_e1 & (pause == 0))
        took_e0, took_e1 = self.normal.valid & flow & in_e0, self.normal.valid & flow & in_e1
        m.d.comb += [
            self.stress.ready.eq(in_stress),
            self.g.ready.eq(in_g),
            self.normal.ready.eq(flow),
            self.idle.eq(in_stress),
        ]
        last = number == self._design.quads - 1
        with m.If(took_stress | took_g | took_e0 | took_e1):
            m.d.sync += number.eq(Mux(last, 0, number + 1))
            with m.If(last):
                m.d.sync += step.eq(step + 1)
        with m.If(self.done):
            m.d.sync += step.eq(0)
        # One cycle between e0 and e1, so that even the p of a single quad is written before it is read.
        with m.If(took_e0 | took_e1):
            m.d.sync += pause.eq(Mux(in_e0, 1, PLACES - 1))
        with m.Elif(pause != 0):
            m.d.sync += pause.eq(pause - 1)
        self._vectors(m, number, behind, took_stress, took_g, took_e0, took_e1, took_e1 & last)
        return m

    def _number(self) -> Signal:
        return Signal(count(self._design.quads - 1))

    def _vectors(
        self,
        m: Module,
        number: Value,
        behind: Signal,
        took_stress: Value,
        took_g: Value,
        took_e0: Value,
        took_e1: Value,
        took_last: Value,
    ) -> None:
        """Memories and butterfly; ``behind`` is the quad that leaves the butterfly next."""
        q = self._design.quads
        m.submodules.base = base = Memory(shape=payloads.vector_quad(self._design), depth=q, init=[])
        m.submodules.stresses = stresses = Memory(shape=payloads.stress_quad(self._design), depth=q, init=[])
        e0, e1 = self._later(m, took_e0), self._later(m, took_e1)
        write, read, write_stress, read_stress = (
            base.write_port(),
            base.read_port(),
            stresses.write_port(),
            stresses.read_port(),
        )
        offset = Signal(payloads.vector_quad(self._design), reset_less=True)
        words = self._butterfly(m, took_e0 | took_e1, offset)
        m.d.sync += offset.eq(Mux(e0[1], read.data.as_value(), 0))
        m.d.comb += [
            write.addr.eq(Mux(took_g, number, behind)),
            write.data.eq(Mux(took_g, self.g.payload.as_value(), Cat(words))),
            write.en.eq(took_g | e0[FOLDED]),
            read.addr.eq(Mux(took_e0, number, behind)),
            read.en.eq(took_e0 | e1[_READ]),
            write_stress.addr.eq(number),
            write_stress.data.eq(self.stress.payload),
            write_stress.en.eq(took_stress),
            read_stress.addr.eq(behind),
            read_stress.en.eq(e1[_READ]),
        ]
        with m.If(e0[FOLDED] | e1[FOLDED]):
            m.d.sync += behind.eq(Mux(behind == q - 1, 0, behind + 1))
        place = Signal(range(PLACES))
        keep = self._keep(m, behind, e1[_READ])
        m.d.sync += place.eq(Mux(e1[_READ], 0, place + 1))
        m.d.sync += [
            self.taxel.p.eq(self._pick(read.data, place)),
            self.taxel.q.eq(self._pick(words, place)),
            self.taxel.stress.eq(self._pick(read_stress.data, place)),
            self.taxel.valid.eq(e1[FOLDED : FOLDED + PLACES].any() & keep.bit_select(place, 1)),
            self.taxel.measured.eq(delayed(m, took_last, FOLDED + PLACES, control=True)),
        ]

    @staticmethod
    def _pick(words: Sequence[Value], place: Value) -> Value:
        """One of four words: a multiplexer, where indexing a view would take a multiplier for the bit's place."""
        return Array(words[k] for k in range(PLACES))[place]

    @staticmethod
    def _later(m: Module, pulse: Value) -> Value:
        """Bit k: ``pulse`` of k cycles ago."""
        seen = Signal(FOLDED + PLACES - 1)
        m.d.sync += seen.eq(Cat(pulse, seen))
        return Cat(pulse, seen)

    def _butterfly(self, m: Module, took: Value, offset: data.View) -> list[Value]:
        """``butterfly(normal - offset)`` modulo the word, which holds p and q by proof."""
        bits = widths(self._design).vector
        held = Signal(payloads.vector_quad(self._design), reset_less=True)
        with m.If(took):
            m.d.sync += held.eq(self.normal.payload)
        same = delayed(m, held.as_value(), 1)
        same = data.View(payloads.vector_quad(self._design), same)

        def register(value: Value) -> Signal:
            word = Signal(signed(bits), reset_less=True)
            m.d.sync += word.eq(value)
            return word

        a, b, c, d = (register(same[k] - offset[k]) for k in range(4))
        plus, minus, plus2, minus2 = register(a + b), register(a - b), register(c + d), register(c - d)
        return [register(v) for v in (plus + plus2, minus + minus2, plus - plus2, minus - minus2)]

    def _keep(self, m: Module, number: Value, look: Value) -> Signal:
        """Which words of a quad are taxels of their own: a bit each, from the static shape of the array."""
        keep = Signal(PLACES, reset_less=True)
        with m.If(look), m.Switch(number):
            for at, row in enumerate(distinct(self._design)):
                with m.Case(at):
                    m.d.sync += keep.eq(sum(1 << place for place in range(PLACES) if row[place]))
        return keep
