"""The assembler: writes the serial core's program, counts its cycles and inserts the pauses that it needs."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from tfra.hdl.serial.isa import NO_POINTER, STORED, ZERO, Dest, Instruction, Left, Op, Operand, Post, Src, When

_SHORTEST_BODY = 2
"""Least number of instructions in a loop's body: the one that ends it, and its delay slot."""


class Assembler:
    """Writes a program and counts its cycles.

    Every instruction is marked with ``stage``, the name of the part of the frame that is written now.
    """

    def __init__(self) -> None:
        self.program: list[Instruction] = []
        self.stage = ""
        self._cycles = [0]  # of the program, and of one turn of each open loop
        self._movable_from = 0  # first instruction after the last loop's end or call
        self._subroutines: dict[str, tuple[list[Instruction], int]] = {}
        self._calls: list[tuple[int, str]] = []
        self._deferred: list[Instruction] | None = None

    @property
    def cycles(self) -> int:
        """Cycles of the program written so far, loops included."""
        return self._cycles[0]

    @property
    def here(self) -> int:
        """Cycles since the innermost open loop began an iteration."""
        return self._cycles[-1]

    # Instructions

    def emit(self, instruction: Instruction) -> None:
        """Append ``instruction``, after the pauses it needs; pauses at a loop's start are placed before the loop."""
        if self._deferred is not None:
            self._deferred.append(instruction)
            return
        while any(instruction.waits_for(other, n) for n, other in enumerate(self.program[:-STORED:-1], 1)):
            if self.program[-1].op == Op.DO:
                self.program.insert(-1, Instruction(stage=self.stage))
                self._cycles[-2] += 1
            else:
                self._append(Instruction())
        self._append(instruction)

    def _append(self, instruction: Instruction) -> None:
        self.program.append(replace(instruction, stage=self.stage))
        self._cycles[-1] += 1

    def op(
        self,
        op: Op,
        dest: Operand | Dest,
        left: Operand | Left,
        source: Operand,
        when: When = When.ALWAYS,
        flag: int = 0,
    ) -> None:
        """Append ``dest = left op source``."""
        if left == Left.T and isinstance(left, Left) and op not in (Op.ADD, Op.FIT):
            raise ValueError("T is a left operand of additions only")
        into = dest if isinstance(dest, Dest) else Dest.M if dest.source == Src.M else dest.source
        first = left.source if isinstance(left, Operand) else left
        self.emit(Instruction(op, first, source.source, into, *_address(dest, source), when, flag))

    def add(self, dest: Operand | Dest, left: Operand | Left, source: Operand, when: When = When.ALWAYS) -> None:
        """dest = left + source"""
        self.op(Op.ADD, dest, left, source, when)

    def sub(self, dest: Operand | Dest, left: Operand | Left, source: Operand, when: When = When.ALWAYS) -> None:
        """dest = left - source"""
        self.op(Op.SUB, dest, left, source, when)

    def move(self, dest: Operand | Dest, source: Operand, when: When = When.ALWAYS) -> None:
        """dest = source"""
        self.op(Op.ADD, dest, ZERO, source, when)

    def rounded(self, dest: Operand | Dest) -> None:
        """dest = T, rounded half up"""
        self.op(Op.ADD, dest, Left.T, Operand(Src.NOTHING))

    def sign(self, flag: int, left: Operand | Left, source: Operand, op: Op = Op.SUB) -> None:
        """Flag F0 or F1 = left op source is negative"""
        self.op(op, Dest.NONE, left, source, flag=1 + flag)

    def act(self, op: Op, source: Operand) -> None:
        """SHIFT, LENGTH or MUL of ``source``."""
        self.op(op, Dest.NONE, ZERO, source)

    def advance(self, pointer: int, by: int) -> None:
        """pointer += by"""
        self.emit(Instruction(pointer=pointer, post=Post.MOVE, immediate=by))

    def nop(self, count: int = 1) -> None:
        """Wait ``count`` cycles."""
        if count > 6:
            turns = (count - 3) // 2  # two or three are left, so that another loop may end here
            with self.loop(turns):
                self.nop(2)
            count -= 1 + 2 * turns
        for _ in range(count):
            self.emit(Instruction())

    @contextmanager
    def deferred(self) -> Iterator[list[Instruction]]:
        """Collect the block's instructions in a list instead of writing them; the caller emits them one by one."""
        collected: list[Instruction] = []
        self._deferred = collected
        yield collected
        self._deferred = None

    # Loops and calls

    @contextmanager
    def loop(self, times: int) -> Iterator[None]:
        """Run the block ``times`` times; the last instruction but one ends it, the last one is its delay slot."""
        if times == 1:
            yield
            return
        self.emit(Instruction(Op.DO, immediate=times - 1))
        self._movable_from = len(self.program)
        self._cycles.append(0)
        yield
        while self._cycles[-1] < _SHORTEST_BODY or len(self.program) - _SHORTEST_BODY < self._movable_from:
            self.nop()
        self.program[-2] = replace(self.program[-2], end=True)
        self._movable_from = len(self.program)
        body = self._cycles.pop()
        self._cycles[-1] += times * body

    def unrolled(self, times: int, copies: int = 4) -> Iterator[None]:
        """``for _ in unrolled(n)``: run the body n times, ``copies`` of it in each iteration of a loop, the rest after
        it."""
        if times >= copies:
            with self.loop(times // copies):
                yield from [None] * copies
        yield from [None] * (times % copies)

    def jump(self, target: int) -> None:
        """Continue at instruction ``target``."""
        self.emit(Instruction(Op.JUMP, immediate=target))
        self.nop()

    def call(self, name: str, body: Callable[[], None]) -> None:
        """Call ``body`` as the subroutine ``name``, which is written once after the program; subroutines do not
        nest."""
        if name not in self._subroutines:
            self._subroutines[name] = self._subroutine(name, body)
        code, cycles = self._subroutines[name]
        delay_slot = self._take_back(code)
        self._calls.append((len(self.program), name))
        self._append(Instruction(Op.JUMP, left=Left.R0))
        self._append(delay_slot)
        self._movable_from = len(self.program)
        self._cycles[-1] += cycles

    def _subroutine(self, name: str, body: Callable[[], None]) -> tuple[list[Instruction], int]:
        """Instructions of ``body`` and of the return, and their cycles."""
        outer = self.program, self._cycles, self._movable_from, self.stage
        self.program, self._cycles, self._movable_from, self.stage = [], [0], 0, name
        body()
        self.emit(Instruction(Op.JUMP, left=Left.T))
        self.nop()
        written = self.program, self._cycles[0]
        self.program, self._cycles, self._movable_from, self.stage = outer
        return written

    def _take_back(self, code: list[Instruction]) -> Instruction:
        """Instruction in the delay slot of a call of ``code``: the last instruction if allowed, otherwise a pause."""
        if len(self.program) > self._movable_from:
            last = self.program[-1]
            early = any(following.waits_for(last, n) for n, following in enumerate(code[: STORED - 1], 1))
            if last.op != Op.DO and not early:
                self._cycles[-1] -= 1
                return self.program.pop()
        return Instruction()

    def link(self) -> int:
        """Put the subroutines after the program; returns the address of the first one."""
        starts, end = {}, len(self.program)
        for name, (body, _) in self._subroutines.items():
            starts[name] = len(self.program)
            self.program += body
        for place, name in self._calls:
            self.program[place] = replace(self.program[place], immediate=starts[name])
        return end


def _address(dest: Operand | Dest, source: Operand) -> tuple[int, Post, int]:
    """Pointer, post and immediate of an instruction: those of its one addressed operand.

    A pointer that takes a constant has both: its own number and the constant's immediate.
    """
    operands = [each for each in (dest, source) if isinstance(each, Operand)]
    addressed = [o for o in operands if o.source in (Src.M, Src.IMM) or o.pointer != NO_POINTER]
    addresses = {(o.pointer, o.post, o.immediate) for o in addressed}
    if len(addresses) < 2:
        return addresses.pop() if addresses else (NO_POINTER, Post.KEEP, 0)
    if isinstance(dest, Operand) and dest.source == Dest.P and source.source == Src.IMM:
        return dest.pointer, Post.KEEP, source.immediate
    raise ValueError("source and destination need the same address")
