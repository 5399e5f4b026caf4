"""The sequencer: the next instruction, and its effective address."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from amaranth import Array, Const, Module, Mux, Signal
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tfra.hdl.serial.isa import ADDRESS_BITS, FIELDS, LOOPS, POINTERS, Instruction, Left, Op, Post

INSTRUCTION = data.StructLayout(FIELDS)


class Sequencer(wiring.Component):
    """Program, program counter, stack of loops and pointers.

    An instruction decides the next address while the one after it is read: that one, in the delay slot, is
    executed in any case.
    """

    def __init__(self, program: Sequence[Instruction]) -> None:
        self._program = [instruction.word for instruction in program]
        super().__init__({
            "advance": In(1),  # ``instruction`` enters execution, and the next one is fetched
            "instruction": Out(INSTRUCTION),
            "address": Out(ADDRESS_BITS),  # the effective address of the instruction
            "valid": Out(1),  # low in the first cycle after reset, which has no instruction
            # write ``pointer_value`` to pointer ``pointer_number``; has priority over a step of that pointer
            "set_pointer": In(1),
            "pointer_number": In(FIELDS["pointer"]),  # below ``POINTERS``
            "pointer_value": In(ADDRESS_BITS),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = sum(FIELDS.values())
        m.submodules.program = memory = Memory(shape=bits, depth=len(self._program), init=self._program)
        read = memory.read_port()
        program_counter = Signal(range(len(self._program)))
        m.d.comb += read.addr.eq(program_counter)
        m.d.comb += read.en.eq(self.advance)
        m.d.comb += self.instruction.eq(read.data)
        with m.If(self.advance):
            m.d.sync += self.valid.eq(1)
            m.d.sync += program_counter.eq(program_counter + 1)
            with m.If(self.valid):
                self._jump(m, program_counter)
        self._move_pointers(m)
        return m

    def _jump(self, m: Module, program_counter: Signal) -> None:
        """Calls, returns, jumps, and loops: stacks of first instructions and of remaining iterations, the innermost
        first."""
        i = self.instruction
        link = Signal.like(program_counter)
        starts = [Signal.like(program_counter, name=f"start{depth}") for depth in range(LOOPS)]
        turns = [Signal(ADDRESS_BITS, name=f"turns{depth}") for depth in range(LOOPS)]
        with m.If(i.op == Op.JUMP):
            m.d.sync += program_counter.eq(Mux(i.left == Left.T, link, i.immediate))
            with m.If(i.left == Left.R0):
                m.d.sync += link.eq(program_counter + 1)
        with m.Elif(i.op == Op.DO):
            for stack, top in ((starts, program_counter), (turns, i.immediate)):
                m.d.sync += [outer.eq(inner) for inner, outer in pairwise(stack)]
                m.d.sync += stack[0].eq(top)
        with m.Elif(i.end):
            with m.If(turns[0] != 0):
                m.d.sync += turns[0].eq(turns[0] - 1)
                m.d.sync += program_counter.eq(starts[0])
            with m.Else():
                for stack in (starts, turns):
                    m.d.sync += [inner.eq(outer) for inner, outer in pairwise(stack)]

    def _move_pointers(self, m: Module) -> None:
        """The address, and the update of its pointer."""
        i = self.instruction
        pointers = [Signal(ADDRESS_BITS, name=f"pointer{number}") for number in range(POINTERS)]
        choices = Array([*pointers, Const(0, ADDRESS_BITS)])
        base = Signal(ADDRESS_BITS)
        moved = Signal(ADDRESS_BITS)
        m.d.comb += base.eq(choices[i.pointer])
        m.d.comb += self.address.eq(base + i.immediate)
        with m.Switch(i.post):
            with m.Case(Post.MOVE):
                m.d.comb += moved.eq(self.address)
            with m.Default():
                m.d.comb += moved.eq(base + Mux(i.post == Post.DOWN, -1, i.post == Post.UP))
        for number, pointer in enumerate(pointers):
            with m.If(self.advance & self.valid & (i.pointer == number)):
                m.d.sync += pointer.eq(moved)
            with m.If(self.set_pointer & (self.pointer_number == number)):
                m.d.sync += pointer.eq(self.pointer_value)
