"""Instructions of the serial core, and the assembler that writes programs of them.

Every instruction takes one cycle: it computes ``left op source`` and hands the result to one destination.  The
field ``address`` is a pointer plus ``immediate``; source and destination share it, so ``m[a] = left op m[a]`` is one
instruction.  What a program has to know of the pipeline:

* a pointer or K is read ``SETTLE`` instructions after it was written at the earliest, a memory word ``STORED``;
* a register or T is read by the next instruction already, but not if that is one of ``LATE``, or behind DIV;
  the assembler waits in these cases, as long as the instructions follow each other in the program;
* SH holds for the next instruction but one;
* a product is there ``MUL_DELAY`` instructions after ``MUL``, sums of products ``MAC_DELAY`` + Q after ``MAC``;
* the instruction behind the one that ends a loop, or jumps, is still executed (the assembler sees to it).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import IntEnum

ADDRESS_BITS = 11
"""Bits of an address and of an immediate word."""

POINTERS, REGISTERS, LOOPS = 7, 6, 3
"""Address pointers, data registers, and how deep loops nest."""

MUL_DELAY, MAC_DELAY, SETTLE, STORED = 3, 6, 3, 4


class Op(IntEnum):
    """Operations; unless said otherwise the result goes to the destination."""

    ADD = 0
    SUB = 1
    PLUS = 2
    """left + max(source, 0)"""
    LESS = 3
    """left - min(source, 0)"""
    ABS = 4
    """left + |source|"""
    OR = 5
    """left | (source ^ sign of source): collects the bits that words need beside their sign"""
    AND = 6
    FIT = 7
    """T rounded to a multiplier operand: T is known to fit, but for rounding up"""
    LIMIT = 8
    """source saturated to a result word; remembers that it was"""
    DIV = 9
    """left - T / 2 if that is not negative, else nothing; K takes the quotient's bit, T is halved"""
    SHIFT = 10
    """T = source shifted right by SH (left if negative), with one bit below the point; K = 0"""
    LENGTH = 11
    """T, rounded, = bit length of the source; K = 0"""
    MUL = 12
    """product = source * Y"""
    MAC = 13
    """start the sums of Q products: operands from the address, coefficients from SP on"""
    DO = 14
    """the loop that starts behind this instruction runs immediate + 1 times"""
    JUMP = 15
    """go on at the immediate; with T as left operand return to behind the last call, with R0 it is a call"""


LATE = (Op.PLUS, Op.LESS, Op.ABS, Op.OR, Op.AND, Op.LIMIT, Op.SHIFT, Op.LENGTH, Op.MUL)
"""Operations that can't have the last result as their source: they take longer, or look at its sign first."""

NO_RESULT = (Op.SHIFT, Op.LENGTH, Op.MUL, Op.MAC, Op.DO, Op.JUMP)
"""Operations without a destination."""


class Left(IntEnum):
    """First operand; ``T`` is rounded half up and goes with additions only.  Registers start at ``R0``."""

    ZERO = 0
    T = 1
    R0 = 2


class Src(IntEnum):
    """Second operand; ``FLOOR`` is T without the bit below the point."""

    M = 0
    FLOOR = 1
    R0 = 2
    IMM = 8
    PRODUCT = 9
    SUM = 10
    """sum of the next lane"""
    IN = 11
    """the next taxel; waits for it"""
    K = 12
    LIMITED = 13
    """-1 if a word was limited since this was read last, else 0"""
    NOTHING = 14


class Dest(IntEnum):
    """Where a result goes."""

    NONE = 0
    M = 1
    R0 = 2
    OUT = 8
    """result stream; waits for it"""
    LAST = 9
    """result stream, last word of a frame"""
    P = 10
    """the pointer of the address field"""
    Y = 11
    SH = 12
    SP = 13
    """address of the next coefficients"""


class Post(IntEnum):
    """What becomes of the pointer behind the address."""

    KEEP = 0
    UP = 1
    DOWN = 2
    MOVE = 3
    """pointer = address"""


class When(IntEnum):
    """Condition; flags are the sign of an earlier result."""

    ALWAYS = 0
    F0 = 2
    NOT_F0 = 3
    F1 = 4
    NOT_F1 = 5


FIELDS = {
    "op": 4,
    "left": 3,
    "source": 4,
    "dest": 4,
    "pointer": 3,
    "post": 2,
    "immediate": ADDRESS_BITS,
    "when": 3,
    "flag": 2,
    "end": 1,
}
"""Bits of an instruction's fields, the lowest first; pointer 7 is zero, flag 1 sets F0 and flag 2 sets F1."""

NO_POINTER = POINTERS


@dataclass(frozen=True)
class Instruction:
    """One word of the program."""

    op: Op = Op.ADD
    left: int = Left.ZERO
    source: int = Src.NOTHING
    dest: int = Dest.NONE
    pointer: int = NO_POINTER
    post: Post = Post.KEEP
    immediate: int = 0
    when: When = When.ALWAYS
    flag: int = 0
    end: bool = False

    def __post_init__(self) -> None:
        if not -(1 << (ADDRESS_BITS - 1)) <= self.immediate < 1 << ADDRESS_BITS:
            raise ValueError(f"immediate {self.immediate} is longer than {ADDRESS_BITS} bits")

    def waits_for(self, other: Instruction, distance: int) -> bool:
        """Whether this one comes too early, ``distance`` instructions behind ``other``."""
        reads = self.source == Src.M and self.pointer == NO_POINTER
        writes = other.dest == Dest.M and other.pointer == NO_POINTER and other.op not in NO_RESULT
        if distance < STORED and reads and writes and self.immediate == other.immediate:
            return True
        if distance < SETTLE:
            if other.dest == Dest.P and other.pointer == self.pointer and self.dest != Dest.P:
                return True
            if other.op == Op.DIV and self.source == Src.K:
                return True
        if distance > 1:
            return False
        if self.op == Op.SHIFT and other.dest == Dest.SH and other.op not in NO_RESULT:
            return True
        written = other.dest if other.op not in NO_RESULT else -1
        if other.op == Op.DIV and written in (self.left, self.source):
            return True
        shifted = other.op in (Op.SHIFT, Op.LENGTH) and self.source == Src.FLOOR
        return self.op in LATE and ((self.source == written and written >= Dest.R0) or shifted)

    @property
    def word(self) -> int:
        """The instruction as an integer."""
        value, place = 0, 0
        for name, bits in FIELDS.items():
            value |= (getattr(self, name) & ((1 << bits) - 1)) << place
            place += bits
        return value


@dataclass(frozen=True)
class Operand:
    """A source, destination or left operand; for memory also its address."""

    source: int
    pointer: int = NO_POINTER
    post: Post = Post.KEEP
    immediate: int = 0

    @property
    def addressed(self) -> bool:
        """Whether the operand uses the address field."""
        return self.source in (Src.M, Src.IMM) or self.pointer != NO_POINTER


R0, R1, R2, R3, R4, R5 = (Operand(Src.R0 + i) for i in range(REGISTERS))
FLOOR, PRODUCT, SUM, IN, K, LIMITED, NOTHING = (
    Operand(s) for s in (Src.FLOOR, Src.PRODUCT, Src.SUM, Src.IN, Src.K, Src.LIMITED, Src.NOTHING)
)
ZERO, T = Left.ZERO, Left.T


def mem(address: int, pointer: int = NO_POINTER, post: Post = Post.KEEP) -> Operand:
    """Memory word at ``address`` plus a pointer."""
    return Operand(Src.M, pointer, post, address)


def imm(value: int) -> Operand:
    """A constant of 11 bits, signed."""
    if not -(1 << (ADDRESS_BITS - 1)) <= value < 1 << (ADDRESS_BITS - 1):
        raise ValueError(f"constant {value} is longer than {ADDRESS_BITS} bits")
    return Operand(Src.IMM, immediate=value)


def pointer(number: int) -> Operand:
    """Address pointer ``number`` as a destination."""
    return Operand(Dest.P, number)


class Assembler:
    """Writes a program and counts its cycles."""

    def __init__(self) -> None:
        self.program: list[Instruction] = []
        self._cycles = [0]
        self._outside = 0  # first instruction behind the last loop or call
        self._subroutines: dict[str, tuple[list[Instruction], int]] = {}
        self._calls: list[tuple[int, str]] = []

    @property
    def cycles(self) -> int:
        """Cycles that what is written so far takes, loops included."""
        return self._cycles[0]

    @property
    def here(self) -> int:
        """Cycles since the innermost open loop began a turn."""
        return self._cycles[-1]

    def emit(self, instruction: Instruction) -> None:
        """Append ``instruction``, behind a pause if the one before needs it; a loop's first pauses stand before it."""
        while any(instruction.waits_for(other, n) for n, other in enumerate(self.program[:-STORED:-1], 1)):
            if self.program[-1].op == Op.DO:
                self.program.insert(-1, Instruction())
                self._cycles[-2] += 1
            else:
                self._append(Instruction())
        self._append(instruction)

    def _append(self, instruction: Instruction) -> None:
        self.program.append(instruction)
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
        into = dest if isinstance(dest, Dest) else Dest.M if dest.source == Src.M else dest.source
        addressed = {(o.pointer, o.post, o.immediate) for o in (dest, source) if isinstance(o, Operand) and o.addressed}
        if len(addressed) > 1:
            if not (isinstance(dest, Operand) and dest.source == Dest.P and source.source == Src.IMM):
                raise ValueError("source and destination need the same address")
            addressed = {(dest.pointer, Post.KEEP, source.immediate)}
        if left == Left.T and isinstance(left, Left) and op not in (Op.ADD, Op.FIT):
            raise ValueError("T is a left operand of additions only")
        address = addressed.pop() if addressed else (NO_POINTER, Post.KEEP, 0)
        first = left.source if isinstance(left, Operand) else left
        self.emit(Instruction(op, first, source.source, into, *address, when, flag))

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
        self.op(Op.ADD, dest, T, NOTHING)

    def sign(self, flag: int, left: Operand | Left, source: Operand, op: Op = Op.SUB) -> None:
        """F0 or F1 = left op source is negative"""
        self.op(op, Dest.NONE, left, source, flag=1 + flag)

    def act(self, op: Op, source: Operand) -> None:
        """SHIFT, LENGTH or MUL of ``source``."""
        self.op(op, Dest.NONE, ZERO, source)

    def go(self, pointer: int, by: int) -> None:
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
    def loop(self, times: int) -> Iterator[None]:
        """Run the block ``times`` times; the last instruction but one ends it, for the pipeline's sake."""
        if times == 1:
            yield
            return
        self.emit(Instruction(Op.DO, immediate=times - 1))
        self._outside = len(self.program)
        self._cycles.append(0)
        yield
        while self._cycles[-1] < 2 or len(self.program) - 2 < self._outside:
            self.nop()
        self.program[-2] = replace(self.program[-2], end=True)
        self._outside = len(self.program)
        body = self._cycles.pop()
        self._cycles[-1] += times * body

    def repeat(self, times: int, body: Callable[[], None], unroll: int = 4) -> None:
        """Run ``body`` ``times`` times, ``unroll`` of them in a turn of a loop."""
        if times >= unroll:
            with self.loop(times // unroll):
                for _ in range(unroll):
                    body()
        for _ in range(times % unroll):
            body()

    def jump(self, target: int) -> None:
        """Go on at instruction ``target``."""
        self.emit(Instruction(Op.JUMP, immediate=target))
        self.nop()

    def call(self, name: str, body: Callable[[], None]) -> None:
        """Run ``body``, which is written once, behind the program, as the subroutine ``name``; none calls another."""
        if name not in self._subroutines:
            outer = self.program, self._cycles, self._outside
            self.program, self._cycles, self._outside = [], [0], 0
            body()
            self.emit(Instruction(Op.JUMP, left=Left.T))
            self.nop()
            self._subroutines[name] = self.program, self._cycles[0]
            self.program, self._cycles, self._outside = outer
        code, cycles = self._subroutines[name]
        behind = self._movable(code)
        self._calls.append((len(self.program), name))
        self._append(Instruction(Op.JUMP, left=Left.R0))
        self._append(behind)
        self._outside = len(self.program)
        self._cycles[-1] += cycles

    def _movable(self, code: list[Instruction]) -> Instruction:
        """Take back the last instruction if it may as well stand behind a call of ``code``; else a pause."""
        if len(self.program) > self._outside:
            last = self.program[-1]
            early = any(following.waits_for(last, n) for n, following in enumerate(code[: STORED - 1], 1))
            if last.op != Op.DO and not early:
                self._cycles[-1] -= 1
                return self.program.pop()
        return Instruction()

    def link(self) -> None:
        """Put the subroutines behind the program."""
        starts = {}
        for name, (body, _) in self._subroutines.items():
            starts[name] = len(self.program)
            self.program += body
        for place, name in self._calls:
            self.program[place] = replace(self.program[place], immediate=starts[name])
