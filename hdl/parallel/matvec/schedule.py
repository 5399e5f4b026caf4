"""Scheduler of the matrix-vector unit: chooses the next product, launches passes and addresses their words."""

from typing import Any

from amaranth import Array, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from tfra.hdl.lib.arithmetic import counter_shape
from tfra.hdl.parallel.matvec.drain import drain_steps
from tfra.hdl.parallel.matvec.images import bases, depth, passes
from tfra.hdl.parallel.matvec.plan import Plan, Source, of_number, stack_number
from tfra.model.fixed.design import Design


def spacing(design: Design, stack: str) -> int:
    """Cycles from the launch of a pass of ``stack`` to that of the next: those of its reads, or those of draining.

    The next pass may be of any stack: the shorter its operand, the sooner its sums follow.  They do so at least two
    cycles later: the drain looks up the words of the pass before in the cycle before it needs them.
    """
    reads, shortest = design.stacks[stack].operand_quads, min(s.operand_quads for s in design.stacks.values())
    return reads + max(0, max(drain_steps(design), 2) - shortest)


class Schedule(wiring.Component):
    """Chooses products, launches their passes and counts through buffer and coefficients.

    A product is chosen when the previous one has launched its last pass, among the available operands whose results
    have a place: frames interleave, and the older one goes first.
    """

    def __init__(self, design: Design, plan: Plan) -> None:
        self._design, self._sources = design, plan.sources
        self._quads = [source.quads(design) for source in plan.sources]
        source = counter_shape(len(plan.sources) - 1)
        super().__init__({
            "wanted": In(len(plan.sources)),  # by source, an operand that may be multiplied is available
            # The operand of its source is for this stack, the second of two.
            **{stack: In(1) for source in plan.sources for stack in source.stacks[1:]},
            "drained": In(1),  # the last words of a pass leave the drain register
            "launch": Out(1),  # a pass begins with the next cycle
            "new": Out(1),  # it is its product's first
            "stack": Out(stack_number(design)),  # its product's in design.stacks
            "parity": Out(1),  # its number, modulo two
            "source": Out(source),  # index of that of its operand
            "oldest": Out(1),  # number of the pass whose words leave the drain register next, modulo two
            "free": Out(len(plan.sources)),  # by source, the last pass of its operand has begun
            "reading": Out(1),  # a quad is read in this cycle
            "last": Out(1),  # it is the last of its pass
            "quad": Out(counter_shape(max(self._quads) - 1)),  # its number
            "read_source": Out(source),  # where it is
            "read_parity": Out(1),  # number of its pass, modulo two
            "address": Out(counter_shape(depth(design) - 1)),  # of its coefficients
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        chosen, ends = self._choose(m)
        self._launch(m, chosen)
        quads, next_quads = (of_number(self._quads, source) for source in (self.read_source, self.source))
        ending = Signal(init=self._quads[0] == 1)  # TIMING: quad -> all that ``last`` enables
        m.d.comb += self.last.eq(self.reading & ending)
        m.d.sync += self.free.eq((self.launch & ends) << self.source)
        with m.If(self.launch):
            m.d.sync += [
                self.reading.eq(1),
                self.quad.eq(0),
                ending.eq(next_quads == 1),
                self.read_source.eq(self.source),
                self.read_parity.eq(self.parity),
            ]
        with m.Elif(self.last):
            m.d.sync += self.reading.eq(0)
        with m.Else():
            m.d.sync += self.quad.eq(self.quad + 1)
            m.d.sync += ending.eq(self.quad == quads - 2)
        self._count_addresses(m)
        return m

    def _choose(self, m: Module) -> tuple[Value, Value]:
        """A product is chosen; its next pass is its last one.

        The buffers' states follow ``free`` by a cycle, so nothing is chosen while it is high.
        """
        chosen = Signal()
        turn = Signal(counter_shape(max(self._passes) - 1))
        ends = Signal()
        m.d.comb += self.new.eq(turn == 0)
        m.d.comb += ends.eq(turn == Array(p - 1 for p in self._passes)[self.stack])
        with m.If(~chosen & ~self.free.any()):
            m.d.sync += chosen.eq(self.wanted.any())
            for number, source in enumerate(self._sources):
                with self._otherwise(m, number):
                    m.d.sync += self.source.eq(number)
                    m.d.sync += self.stack.eq(self._stack_of(source))
        with m.If(self.launch):
            m.d.sync += turn.eq(Mux(ends, 0, turn + 1))
            m.d.sync += chosen.eq(~ends)
        return chosen, ends

    @property
    def _passes(self) -> list[int]:
        return [passes(self._design, name) for name in self._design.stacks]

    def _otherwise(self, m: Module, number: int) -> Any:
        """The condition that the source ``number`` is wanted, and none before it; the last needs none of its own."""
        if number == len(self._sources) - 1:
            return m.Else()
        return m.Elif(self.wanted[number]) if number else m.If(self.wanted[number])

    def _stack_of(self, source: Source) -> Value | int:
        """Number of the stack that the operand of ``source`` is for."""
        first, *second = (list(self._design.stacks).index(name) for name in source.stacks)
        return Mux(getattr(self, source.stacks[1]), second[0], first) if second else first

    def _launch(self, m: Module, chosen: Value) -> None:
        """A pass is launched when it is due and one of two places between launch and drain is free."""
        busy = Signal(2)
        waits = [spacing(self._design, name) - 1 for name in self._design.stacks]
        # Before the first pass, too: the drain captures the sums' start values.
        left = Signal(counter_shape(max(waits)), init=min(waits))
        due = Signal()
        with m.If(self.launch):
            m.d.sync += left.eq(of_number(waits, self.stack))
            m.d.sync += due.eq(0)
        with m.Elif(~due):
            m.d.sync += left.eq(left - 1)
            m.d.sync += due.eq(left == 1)
        m.d.comb += self.launch.eq(due & chosen & ~busy.bit_select(self.parity, 1))
        m.d.sync += busy.eq((busy | (self.launch << self.parity)) & ~(self.drained << self.oldest))
        m.d.sync += self.parity.eq(self.parity ^ self.launch)
        m.d.sync += self.oldest.eq(self.oldest ^ self.drained)

    def _count_addresses(self, m: Module) -> None:
        """Coefficients are read in their order; only a product's first pass jumps, to its stack."""
        with m.If(self.launch & self.new):
            m.d.sync += self.address.eq(Array(bases(self._design)[name] for name in self._design.stacks)[self.stack])
        with m.Elif(self.launch | (self.reading & ~self.last)):
            m.d.sync += self.address.eq(self.address + 1)
