"""Pieces of program that the phases of a frame share.  Registers that a routine changes are named with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tfra.hdl.serial.isa import (
    FLOOR,
    MAC_DELAY,
    MUL_DELAY,
    NOTHING,
    PRODUCT,
    R0,
    R1,
    R2,
    R3,
    R4,
    R5,
    SUM,
    ZERO,
    Assembler,
    Dest,
    Instruction,
    K,
    Op,
    Operand,
    Post,
    Src,
    T,
    When,
    imm,
    mem,
    pointer,
)
from tfra.hdl.serial.program.memory import Map, bases, operator_of, stride
from tfra.hdl.serial.sizes import sizes
from tfra.model.fixed.cordic import angle_table, iterations
from tfra.model.fixed.design import Design
from tfra.model.fixed.scalars import scalar_fraction


class Routines:
    """Writes routines for one design with ``a`` into the places of ``map``."""

    def __init__(self, design: Design) -> None:
        self.design, self.a, self.map = design, Assembler(), Map(design)
        self.sizes = sizes(design)
        self.q = design.quads

    # Scalars

    def at(self, name: str, words: int = 1) -> Operand:
        """The word called ``name``."""
        return mem(self.map.scalar(name, words))

    def const(self, value: int) -> Operand:
        """A source that is ``value``."""
        return imm(value) if -1024 <= value < 1024 else mem(self.map.constants(int(value)))

    def shift(self, dest: Operand | Dest, source: Operand, amount: int | Operand | None = None) -> None:
        """dest = source >> amount, towards minus infinity; SH stays as it is for ``None``."""
        self._shift(source, amount)
        self.a.move(dest, FLOOR)

    def round_shift(self, dest: Operand | Dest, source: Operand, amount: int | Operand | None = None) -> None:
        """dest = source >> amount, rounded half up."""
        self._shift(source, amount)
        self.a.rounded(dest)

    def _shift(self, source: Operand, amount: int | Operand | None) -> None:
        if amount is not None:
            self.a.move(Dest.SH, self.const(amount) if isinstance(amount, int) else amount)
        self.a.act(Op.SHIFT, source)

    def multiply_all(self, *pairs: tuple[Operand, Operand]) -> None:
        """Each register of ``pairs`` = its source * Y, for up to three of them."""
        for _, source in pairs:
            self.a.act(Op.MUL, source)
        self.a.nop(MUL_DELAY - len(pairs))
        for register, _ in pairs:
            self.a.move(register, PRODUCT)

    def length(self, dest: Operand | Dest, source: Operand) -> None:
        """dest = bit length of ``source``"""
        self.a.act(Op.LENGTH, source)
        self.a.rounded(dest)

    def significant(self, dest: Operand | Dest, words: Sequence[Operand], into: Operand = R5) -> None:
        """dest = bits that ``words`` need together; uses ``into``."""
        for number, word in enumerate(words):
            self.a.op(Op.OR, into, into if number else ZERO, word)
        self.length(dest, into)

    def normalise(self, words: Sequence[Operand], bits: int, significant: Operand) -> None:
        """Fill ``bits`` with each of ``words``, in place; uses R5 and F0, leaves the bits needed in ``significant``.

        Rounding is the only thing that can make a word too long.
        """
        a = self.a
        self.significant(R5, words)
        a.sub(Dest.SH, R5, imm(bits - 1))
        a.move(significant, R5)
        limit = 1 << (bits - 1)
        for word in words:
            if bits == self.sizes.operand:
                self._shift(word, None)
                a.op(Op.FIT, word, T, NOTHING)
                continue
            self.round_shift(R5, word)
            a.sign(0, R5, self.const(limit))
            a.move(R5, self.const(limit - 1), When.NOT_F0)
            a.move(word, R5)

    def least(self, word: Operand, limit: int) -> None:
        """word = min(word, limit); uses F0."""
        self.a.sign(0, word, self.const(limit))
        self.a.move(word, self.const(limit), When.NOT_F0)

    def divide(self, fraction: int) -> None:
        """R0 = R0 / R1, both positive, with ``fraction`` bits, rounded half up; the quotient is operand + 1 bits long
        at most.  Uses T and SH."""
        self.a.move(Dest.SH, imm(-(fraction + 1)))
        self.a.call("divide", self._divide)

    def _divide(self) -> None:
        a, bits = self.a, self.sizes.operand + 2
        a.act(Op.SHIFT, R0)
        a.move(Dest.SH, imm(1 - bits))
        a.move(R0, FLOOR)
        a.act(Op.SHIFT, R1)
        with a.loop(bits):
            a.op(Op.DIV, R0, R0, FLOOR)
            a.nop()
        a.move(Dest.SH, imm(1))
        a.move(R0, K)
        self.round_shift(R0, R0)

    def cordic(self) -> None:
        """R0 = modulus of (R0, R1) with R0 >= 0, R2 = R2 + angle; uses R3, R4, F0, pointer 0, T and SH."""
        self.a.call("cordic", self._cordic)

    def _cordic(self) -> None:
        a, up, down = self.a, When.F0, When.NOT_F0
        self.points(p0=self.map.constants(*angle_table(self.design)))
        a.move(R4, imm(0))
        with a.loop(iterations(self.design)):
            a.move(Dest.SH, R4)
            a.op(Op.ADD, Dest.NONE, ZERO, R1, flag=1)
            a.act(Op.SHIFT, R1)
            a.move(R3, FLOOR)
            a.act(Op.SHIFT, R0)
            a.add(R0, R0, R3, down)
            a.sub(R0, R0, R3, up)
            a.sub(R1, R1, FLOOR, down)
            a.add(R1, R1, FLOOR, up)
            a.add(R2, R2, mem(0, 0), down)
            a.sub(R2, R2, mem(0, 0, Post.UP), up)
            a.add(R4, R4, imm(1))

    def address(self, value: int) -> Operand:
        """A source that is the address ``value``."""
        return Operand(Src.IMM, immediate=value)

    def points(self, **values: int) -> None:
        """p0=..., p1=...: set pointers."""
        for name, value in values.items():
            self.a.move(pointer(int(name[1:])), self.address(value))

    # Vectors

    def fill(self, vector: int, operand: int, significant: Operand) -> None:
        """Each parity of ``vector`` as multiplier words in ``operand``, and the four numbers of bits needed.

        Uses R0, R1, T, SH and pointers 0 to 3.
        """
        self.points(p0=vector, p1=vector, p2=operand, p3=significant.immediate)
        self.a.call("fill", self._fill)

    def _fill(self) -> None:
        a = self.a
        with a.loop(4):
            a.move(R0, imm(0))
            a.repeat(self.q, lambda: a.op(Op.OR, R0, R0, mem(0, 0, Post.UP)))
            self.length(R1, R0)
            a.move(mem(0, 3, Post.UP), R1)
            a.sub(Dest.SH, R1, imm(self.sizes.operand - 1))
            with a.loop(self.q):
                a.act(Op.SHIFT, mem(0, 1, Post.UP))
                a.op(Op.FIT, mem(0, 2, Post.UP), T, NOTHING)

    def combine(self, vector: int, operand: int, significant: Operand) -> None:
        """vector = vector + Y * x, x as ``fill`` left it; uses R0, T, SH and pointers 0 to 2."""
        self.points(p0=operand, p1=vector, p2=significant.immediate)
        self.a.call("combine", self.add_scaled)

    def add_scaled(self) -> None:
        """``combine`` with its pointers set."""
        a = self.a
        a.act(Op.MUL, mem(0, 0, Post.UP))
        with a.loop(4):
            a.move(R0, imm(scalar_fraction(self.design) + self.sizes.operand - 1))
            a.sub(Dest.SH, R0, mem(0, 2, Post.UP))
            with a.loop(self.q):
                a.act(Op.MUL, mem(0, 0, Post.UP))
                a.act(Op.SHIFT, PRODUCT)
                a.add(mem(0, 1, Post.UP), T, mem(0, 1, Post.UP))

    def product(self, name: str, operand: int, significant: Operand) -> None:
        """Results of operator ``name`` for the vector ``operand``, to where pointer 2 points, and the words behind.

        Uses R0, R1, T, SH and pointers 0, 1, 2 and 5.
        """
        a, design = self.a, self.design
        operator = operator_of(design, name)
        sources = [parity ^ operator.flip for parity in range(4)]
        table = [word for s in sources for word in (operand + s * self.q, significant.immediate + s)]
        a.move(Dest.SP, self.const(bases(design)[name]))
        self.points(p5=self.map.constants(*table))
        a.move(R1, imm(operator.fraction + self.sizes.operand - 1))
        quads = stride(design, operator)
        a.call(f"product of {quads}", lambda: self._product(quads))

    def _product(self, quads: int) -> None:
        """Sums of a group run while those of the last one are stored: they are read behind the start of a new one, as
        soon as they are there, but before it ends.  The next parity's pointers are set while its last group runs."""
        a, lanes = self.a, self.sizes.lanes
        times, late = -(-quads // lanes), self.q + MAC_DELAY
        spill = times * lanes - quads
        read = min(MAC_DELAY, late - 2 * lanes + 1)
        turn = max(self.q, late - read, read + 2 * lanes)
        start = Instruction(Op.MAC, pointer=0)
        self._next_parity()
        with a.loop(4):
            a.sub(Dest.SH, R1, mem(0, 1))
            a.emit(start)
            if times > 1:
                a.nop(turn - 2)
                with a.loop(times - 1):
                    a.emit(start)
                    a.nop(read - 1)
                    self._store(lanes)
                    a.nop(turn - read - 2 * lanes)
            before = a.here
            self._next_parity()
            a.nop(max(0, (late - turn if times > 1 else late - 1) - (a.here - before)))
            self._store(lanes)
            if spill:
                a.go(2, -spill)

    def _next_parity(self) -> None:
        """Pointers 0 and 1 from the table at pointer 5."""
        for number in range(2):
            self.a.move(R0, mem(0, 5, Post.UP))
            self.a.move(pointer(number), R0)

    def _store(self, lanes: int) -> None:
        for _ in range(lanes):
            self.a.act(Op.SHIFT, SUM)
            self.a.rounded(mem(0, 2, Post.UP))

    def butterfly(self, sources: Sequence[Operand], targets: Sequence[Operand], less: int | None = None) -> None:
        """Four words to their sums and differences; changes R0 to R5.

        With ``less``, a distance, the words that lie that far behind the sources are subtracted first.
        """
        a = self.a
        if less is not None:
            for register, source in zip((R0, R1, R2, R3), sources, strict=True):
                a.move(register, mem(source.immediate, source.pointer))
                a.sub(register, register, mem(source.immediate + less, source.pointer, source.post))
            self.fold((R0, R1, R2, R3), (R4, R5), targets)
            return
        for word, total, (first, second) in ((R0, R4, sources[:2]), (R2, R5, sources[2:])):
            a.move(word, first)
            a.add(total, word, replace(second, post=Post.KEEP))
            a.sub(word, word, second)
        self._fold((R4, R0, R5, R2), targets)

    def fold(self, words: Sequence[Operand], spare: Sequence[Operand], targets: Sequence[Operand]) -> None:
        """Sums and differences of four registers; changes them and the two ``spare`` ones.

        The first two targets may be the second and the fourth word, the third the first spare, the last the first word.
        """
        (one, two, three, four), (left, right), a = words, spare, self.a
        a.add(left, one, two)
        a.sub(one, one, two)
        a.add(right, three, four)
        a.sub(three, three, four)
        self._fold((left, one, right, three), targets)

    def _fold(self, halves: Sequence[Operand], targets: Sequence[Operand]) -> None:
        """Sums and differences of sum and difference of the first two words and of the others."""
        (left, one, right, three), a = halves, self.a
        a.add(targets[0], left, right)
        a.add(targets[1], one, three)
        a.sub(targets[2], left, right)
        a.sub(targets[3], one, three)

    def quad(self, vector: int, number: int, up: bool = True) -> list[Operand]:
        """The four parities of the quad at pointer ``number``, which goes on behind the last one."""
        last = Post.UP if up else Post.KEEP
        return [mem(vector + k * self.q, number, last if k == 3 else Post.KEEP) for k in range(4)]

    def mirrors(self) -> list[Operand]:
        """The four mirror taxels at pointers 0 to 3, which go on to the next quad of the row."""
        return [mem(0, number, Post.DOWN if number & 1 else Post.UP) for number in range(4)]

    def start_mirrors(self, taxels: int) -> None:
        """Pointers 0 to 3 at the corners of a row-major map."""
        rows, columns = self.design.sensor.rows, self.design.sensor.columns
        self.points(
            p0=taxels, p1=taxels + columns - 1, p2=taxels + (rows - 1) * columns, p3=taxels + rows * columns - 1
        )

    def next_mirrors(self) -> None:
        """Pointers 0 to 3 from behind a row of quads to the next one."""
        columns, half = self.design.sensor.columns, self.design.quad_columns
        for number, by in enumerate((columns - half, columns + half, -columns - half, half - columns)):
            self.a.go(number, by)
