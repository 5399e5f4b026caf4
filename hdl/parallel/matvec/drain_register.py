"""The drain register: it captures all sums of a pass at once and sends W words a cycle."""

from typing import Any

from amaranth import Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.lib.pipeline import register
from tfra.hdl.lib.ram import Ram
from tfra.model.fixed.design import Design


def drain_steps(design: Design) -> int:
    """Cycles in which the words of a pass leave the drain register."""
    return design.architecture.mac_lanes // design.architecture.vector_words


class DrainRegister(wiring.Component):
    """L sums in, W words a cycle out, each minus its lane's sum of the pass before.

    Lanes accumulate from pass to pass, modulo their word.  The difference is exact, since the sum of a pass fits the
    word.

    ==================  =============  ============  =============  ===============================================
    state               ``capturing``  ``draining``  ``last_step``  in this cycle
    ==================  =============  ============  =============  ===============================================
    empty               0              0             any            nothing; the register shifts all the same, so
                                                                    that its words have one enable
    capture             1              0             any            sums are captured; words leave from the next
                                                                    cycle on
    draining            0              1             0              W words leave
    last words          0              1             1              the last W words leave; empty follows
    last, and capture   1              1             1              the last W words leave, and sums are captured
    ==================  =============  ============  =============  ===============================================

    After a reset (``after_reset``) the sums, which may be anything, are captured once, as those of a pass before the
    first.  They are the base of its differences, not results: ``primed`` is high when they have left.
    """

    def __init__(self, design: Design) -> None:
        self._words, self._steps = design.architecture.vector_words, drain_steps(design)
        accumulator = signed(design.widths.accumulator)
        super().__init__({
            "sums": In(accumulator).array(design.architecture.mac_lanes),  # L running sums
            # High a cycle before the sums are those of a pass; passes are at least as many cycles apart as the
            # register takes to drain.
            "completing": In(1),
            "complete": Out(1),  # a cycle after ``completing``: sums are captured
            "draining": Out(1),  # words leave
            "primed": Out(1),  # they are those of a pass
            "words": Out(accumulator).array(self._words),  # the words that leave
            "drained": Out(1),  # the last words of a pass leave
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        after_reset = Signal(init=1)
        capturing = Signal()
        last_step = Signal()
        next_step = Signal(counter_shape(self._steps - 1))
        m.d.sync += [
            after_reset.eq(0),
            self.complete.eq(self.completing),
            capturing.eq(self.completing | after_reset),
            next_step.eq(Mux(self.completing | after_reset, 0, next_step + 1)),
            last_step.eq(next_step == self._steps - 1),
            self.draining.eq(capturing | (self.draining & ~last_step)),
            self.primed.eq(self.primed | (self.draining & last_step)),
        ]
        m.d.comb += self.drained.eq(self.draining & last_step & self.primed)
        leaving = self._shift(m, capturing)
        before = self._before(m, leaving, next_step)
        for number, word in enumerate(leaving):
            bits = len(word)
            m.d.comb += self.words[number].eq((word - before.word_select(number, bits))[:bits].as_signed())
        return m

    def _shift(self, m: Module, capturing: Value) -> list[Value]:
        """The register, and the words that leave it."""
        captured = [Signal.like(total, name=f"captured{lane}", reset_less=True) for lane, total in enumerate(self.sums)]
        with m.If(capturing):
            m.d.sync += (word.eq(total) for word, total in zip(captured, self.sums, strict=True))
        with m.Else():
            m.d.sync += (word.eq(behind) for word, behind in zip(captured, captured[self._words :], strict=False))
        return captured[: self._words]

    def _before(self, m: Module, leaving: list[Value], next_step: Value) -> Value:
        """The same words of the pass before, from a memory that is read a cycle before it is written."""
        bits = len(leaving[0]) * len(leaving)
        before = Ram(m, "before", unsigned(bits), 1 << len(next_step))
        before.write(self.draining, register(m, next_step, "step"), Cat(leaving))
        return register(m, before.look_up(next_step), "before")
