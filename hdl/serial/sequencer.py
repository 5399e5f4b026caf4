"""The sequencer: which instruction comes next, and the address it means."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from amaranth import Array, Const, Elaboratable, Module, Mux, Signal
from amaranth.lib import data
from amaranth.lib.memory import Memory

from tfra.hdl.serial.isa import ADDRESS_BITS, FIELDS, LOOPS, POINTERS, Instruction, Left, Op, Post

LAYOUT = data.StructLayout(FIELDS)


class Sequencer(Elaboratable):
    """Program, loops and pointers.

    In a cycle with ``advance``, ``instruction`` with its ``address`` goes on to be executed; ``valid`` is low for the
    first of them after reset.  ``set_pointer`` writes ``value`` to pointer ``number``.
    """

    def __init__(self, program: Sequence[Instruction]) -> None:
        self._program = [instruction.word for instruction in program]
        self.advance, self.valid = Signal(), Signal()
        self.instruction = Signal(LAYOUT)
        self.address = Signal(ADDRESS_BITS)
        self.set_pointer, self.number, self.value = Signal(), Signal(FIELDS["pointer"]), Signal(ADDRESS_BITS)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = sum(FIELDS.values())
        m.submodules.program = memory = Memory(shape=bits, depth=len(self._program), init=self._program)
        read = memory.read_port()
        counter = Signal(range(len(self._program)))
        m.d.comb += [read.addr.eq(counter), read.en.eq(self.advance), self.instruction.eq(read.data)]
        with m.If(self.advance):
            m.d.sync += [self.valid.eq(1), counter.eq(counter + 1)]
            with m.If(self.valid):
                self._jump(m, counter)
        self._point(m)
        return m

    def _jump(self, m: Module, counter: Signal) -> None:
        i = self.instruction
        link = Signal.like(counter)
        starts = [Signal.like(counter, name=f"start{depth}") for depth in range(LOOPS)]
        turns = [Signal(ADDRESS_BITS, name=f"turns{depth}") for depth in range(LOOPS)]
        with m.If(i.op == Op.JUMP):
            m.d.sync += counter.eq(Mux(i.left == Left.T, link, i.immediate))
            with m.If(i.left == Left.R0):
                m.d.sync += link.eq(counter + 1)
        with m.Elif(i.op == Op.DO):
            for stack, top in ((starts, counter), (turns, i.immediate)):
                m.d.sync += [below.eq(above) for above, below in pairwise(stack)]
                m.d.sync += stack[0].eq(top)
        with m.Elif(i.end):
            with m.If(turns[0] != 0):
                m.d.sync += [turns[0].eq(turns[0] - 1), counter.eq(starts[0])]
            with m.Else():
                for stack in (starts, turns):
                    m.d.sync += [above.eq(below) for above, below in pairwise(stack)]

    def _point(self, m: Module) -> None:
        i = self.instruction
        pointers = [Signal(ADDRESS_BITS, name=f"pointer{number}") for number in range(POINTERS)]
        base, moved = Signal(ADDRESS_BITS), Signal(ADDRESS_BITS)
        choices = Array([*pointers, Const(0, ADDRESS_BITS)])
        m.d.comb += [base.eq(choices[i.pointer]), self.address.eq(base + i.immediate)]
        with m.Switch(i.post):
            with m.Case(Post.MOVE):
                m.d.comb += moved.eq(self.address)
            with m.Default():
                m.d.comb += moved.eq(base + Mux(i.post == Post.DOWN, -1, i.post == Post.UP))
        for number, pointer in enumerate(pointers):
            with m.If(self.advance & self.valid & (i.pointer == number)):
                m.d.sync += pointer.eq(moved)
            with m.If(self.set_pointer & (self.number == number)):
                m.d.sync += pointer.eq(self.value)
