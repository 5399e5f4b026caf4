"""Scheduler of the matrix-vector unit: chooses the next product, launches passes and addresses their words."""

from __future__ import annotations

from typing import Any

from amaranth import Array, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.parallel.matvec.drain_register import drain_steps
from tfra.hdl.parallel.matvec.images import bases, depth, passes
from tfra.model.fixed.design import Design

SOURCES = ("vector", "n", "b")
"""Operand buffers, the one that helps the oldest frame first."""


def spacing(design: Design) -> int:
    """Cycles from the launch of a pass to that of the next: those of its reads, or those of draining its words.

    At least two: the drain looks up the words of the pass before in the cycle before it needs them.
    """
    return max(design.quads, drain_steps(design), 2)


class Schedule(wiring.Component):
    """Chooses products, launches their passes and counts through buffer and coefficients.

    A product is chosen when the previous one has launched its last pass, among the available operands whose results
    have a place: frames interleave, and the older one goes first.

    Members:
        wanted: by source of :data:`SOURCES`, an operand that may be multiplied is available.
        force: the vector is d.
        drained: the last words of a pass leave the drain register.
        launch: a pass begins with the next cycle.
        new: it is its product's first.
        stack: its product's in self._design.stacks.
        parity: its number, modulo two.
        source: index of its operand in :data:`SOURCES`.
        oldest: number of the pass whose words leave the drain register next, modulo two.
        free: by source, the last pass of its operand has begun.
        reading: a quad is read in this cycle.
        last: it is the last of its pass.
        quad: its number.
        read_source: where it is.
        read_parity: number of its pass, modulo two.
        address: of its coefficients.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        super().__init__(
            {
                "wanted": In(len(SOURCES)),
                "force": In(1),
                "drained": In(1),
                "launch": Out(1),
                "new": Out(1),
                "stack": Out(2),
                "parity": Out(1),
                "source": Out(2),
                "oldest": Out(1),
                "free": Out(len(SOURCES)),
                "reading": Out(1),
                "last": Out(1),
                "quad": Out(counter_shape(design.quads - 1)),
                "read_source": Out(2),
                "read_parity": Out(1),
                "address": Out(counter_shape(depth(design) - 1)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        chosen, ends = self._choose(m)
        self._launch(m, chosen)
        quads = self._design.quads
        ending = Signal(init=quads == 1)  # TIMING: quad -> all that ``last`` enables
        m.d.comb += self.last.eq(self.reading & ending)
        m.d.sync += self.free.eq((self.launch & ends) << self.source)
        with m.If(self.launch):
            m.d.sync += [
                self.reading.eq(1),
                self.quad.eq(0),
                ending.eq(quads == 1),
                self.read_source.eq(self.source),
                self.read_parity.eq(self.parity),
            ]
        with m.Elif(self.last):
            m.d.sync += self.reading.eq(0)
        with m.Else():
            m.d.sync += [self.quad.eq(self.quad + 1), ending.eq(self.quad == quads - 2)]
        self._count_addresses(m)
        return m

    def _choose(self, m: Module) -> tuple[Value, Value]:
        """A product is chosen; its next pass is its last one.

        The buffers' states follow ``free`` by a cycle, so nothing is chosen while it is high.
        """
        chosen = Signal()
        turn = Signal(counter_shape(max(self._passes) - 1))
        ends = Signal()
        names = {name: number for number, name in enumerate(self._design.stacks)}
        m.d.comb += [self.new.eq(turn == 0), ends.eq(turn == Array(p - 1 for p in self._passes)[self.stack])]
        with m.If(~chosen & ~self.free.any()):
            m.d.sync += chosen.eq(self.wanted.any())
            with m.If(self.wanted[0]):
                m.d.sync += [self.source.eq(0), self.stack.eq(Mux(self.force, names["force"], names["normal"]))]
            with m.Elif(self.wanted[1]):
                m.d.sync += [self.source.eq(1), self.stack.eq(names["residual"])]
            with m.Else():
                m.d.sync += [self.source.eq(2), self.stack.eq(names["contact"])]
        with m.If(self.launch):
            m.d.sync += [turn.eq(Mux(ends, 0, turn + 1)), chosen.eq(~ends)]
        return chosen, ends

    @property
    def _passes(self) -> list[int]:
        return [passes(self._design, name) for name in self._design.stacks]

    def _launch(self, m: Module, chosen: Value) -> None:
        """A pass is launched when it is due and one of two places between launch and drain is free."""
        busy = Signal(2)
        wait = spacing(self._design) - 1
        left = Signal(
            counter_shape(wait), init=wait
        )  # before the first pass, too: the drain captures the sums' start values
        due = Signal()
        with m.If(self.launch):
            m.d.sync += [left.eq(wait), due.eq(0)]
        with m.Elif(~due):
            m.d.sync += [left.eq(left - 1), due.eq(left == 1)]
        m.d.comb += self.launch.eq(due & chosen & ~busy.bit_select(self.parity, 1))
        m.d.sync += busy.eq((busy | (self.launch << self.parity)) & ~(self.drained << self.oldest))
        m.d.sync += [self.parity.eq(self.parity ^ self.launch), self.oldest.eq(self.oldest ^ self.drained)]

    def _count_addresses(self, m: Module) -> None:
        """Coefficients are read in their order; only a product's first pass jumps, to its stack."""
        with m.If(self.launch & self.new):
            m.d.sync += self.address.eq(Array(bases(self._design)[name] for name in self._design.stacks)[self.stack])
        with m.Elif(self.launch | (self.reading & ~self.last)):
            m.d.sync += self.address.eq(self.address + 1)
