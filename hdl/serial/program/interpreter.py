"""The serial core as integers: executes a program instruction by instruction, bit-exact to the gateware, and raises
hazards."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from tfra.hdl.serial import isa
from tfra.hdl.serial.isa import Dest, Instruction, Left, Op, Post, Src
from tfra.hdl.serial.sizes import Sizes

_SUMS: dict[Op, Callable[[int, int], int]] = {
    Op.ADD: lambda left, source: left + source,
    Op.SUB: lambda left, source: left - source,
    Op.PLUS: lambda left, source: left + max(source, 0),
    Op.LESS: lambda left, source: left - min(source, 0),
    Op.ABS: lambda left, source: left + abs(source),
    Op.OR: lambda left, source: left | (source if source >= 0 else ~source),
    Op.AND: lambda left, source: left & source,
}
"""Operations whose result follows from both operands."""

_SOURCES: dict[int, Callable[["Interpreter", Instruction], int]] = {
    Src.FLOOR: lambda machine, _: machine.t >> 1,
    Src.IMM: lambda _, i: wrap(i.immediate, isa.ADDRESS_BITS),
    Src.PRODUCT: lambda machine, _: machine.product,
    Src.SUM: lambda machine, _: machine.sums.pop(0),
    Src.K: lambda machine, _: machine.k,
    Src.NOTHING: lambda *_: 0,
}
"""Operands that are neither in memory, nor in a data register, nor a word of a stream or flag."""


class Hazard(Exception):
    """A program reads a value that is not available yet, or leaves a word's range."""


def wrap(value: int, bits: int) -> int:
    """``value`` as a signed word of ``bits``."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


class Step(NamedTuple):
    """An instruction that was executed in ``cycle``, from place ``pc`` of the program.

    ``value`` is the written value, as stored in the destination; ``None`` if it wrote nothing.  ``address`` is its
    effective address, used or not.
    """

    cycle: int
    pc: int
    instruction: Instruction
    address: int
    value: int | None


@dataclass
class Interpreter:
    """State of the machine; ``lengths`` (from which MAC chooses), ``program``, ``memory`` and ``store`` (words of
    ``lanes`` coefficients) are given.

    ``cycle`` counts instructions: a cycle each.  A result that is too long for a word raises ``Hazard``.
    """

    sizes: Sizes
    lengths: Sequence[int]
    program: Sequence[Instruction]
    memory: list[int]
    store: Sequence[Sequence[int]]

    # What the gateware has, too
    cycle: int = 0
    pc: int = 0
    link: int = 0
    loops: list[list[int]] = field(default_factory=list)  # first instruction, remaining iterations
    registers: list[int] = field(default_factory=lambda: [0] * isa.REGISTERS)
    pointers: list[int] = field(default_factory=lambda: [0] * (isa.POINTERS + 1))
    flags: list[bool] = field(default_factory=lambda: [False, False])
    limited: int = 0
    t: int = 0
    k: int = 0
    y: int = 0
    sh: int = 0
    sp: int = 0
    product: int = 0
    sums: list[int] = field(default_factory=list)

    # On their way, with the cycle of their arrival
    coming_products: list[tuple[int, int]] = field(default_factory=list)
    coming_sums: list[tuple[int, list[int]]] = field(default_factory=list)

    # For hazards: when words and pointers were written, the place of the instruction before, the pairs of places that
    # may follow each other, when the lanes are free
    word_written: dict[int, int] = field(default_factory=dict)
    pointer_written: dict[int, int] = field(default_factory=dict)
    before: int | None = None
    allowed: set[tuple[int | None, int]] = field(default_factory=set)
    lanes_free: int = 0

    def steps(self, taxels: Iterator[int]) -> Iterator[Step]:
        """Execute until ``taxels`` end; yields every instruction, after it was executed."""
        target: int | None = None
        while True:
            instruction, pc = self.program[self.pc], self.pc
            following = pc + 1 if target is None else target  # after the delay slot
            target = self._sequence(instruction)
            try:
                address, value = self._execute(instruction, taxels)
            except StopIteration:  # there is no taxel
                return
            yield Step(self.cycle, pc, instruction, address, value)
            self.pc, self.cycle = following, self.cycle + 1

    def _sequence(self, i: Instruction) -> int | None:
        """Target of a jump after the next instruction, or None."""
        if i.op == Op.DO:
            self.loops.append([self.pc + 1, i.immediate])
            return None
        if i.op == Op.JUMP:
            target = self.link if i.left == Left.T else i.immediate
            self.link = self.pc + 2 if i.left == Left.R0 else self.link
            return target
        if i.end:
            start, left = self.loops[-1]
            if left:
                self.loops[-1][1] -= 1
                return start
            self.loops.pop()
        return None

    def _address(self, i: Instruction) -> int:
        if i.dest != Dest.P and self.cycle - self.pointer_written.get(i.pointer, -isa.SETTLE) < isa.SETTLE:
            raise Hazard(f"instruction {self.pc}: pointer {i.pointer} is used too early")
        address = (self.pointers[i.pointer] + i.immediate) % (1 << isa.ADDRESS_BITS)
        if i.pointer != isa.NO_POINTER:
            step = {Post.KEEP: 0, Post.UP: 1, Post.DOWN: -1}
            new = address if i.post == Post.MOVE else self.pointers[i.pointer] + step[i.post]
            self.pointers[i.pointer] = new % (1 << isa.ADDRESS_BITS)
        return address

    def _source(self, i: Instruction, address: int, taxels: Iterator[int]) -> int:
        s = i.source
        if Src.R0 <= s < Src.R0 + isa.REGISTERS:
            return self.registers[s - Src.R0]
        if s == Src.M:
            if self.cycle - self.word_written.get(address, -isa.STORED) < isa.STORED:
                raise Hazard(f"instruction {self.pc}: word {address} is read too early")
            return self.memory[address]
        if s == Src.IN:
            return next(taxels)
        if s == Src.LIMITED:
            value, self.limited = self.limited, 0
            return value
        return _SOURCES[s](self, i)

    def _execute(self, i: Instruction, taxels: Iterator[int]) -> tuple[int, int | None]:
        """Address of an instruction, and the value it writes."""
        while self.coming_products and self.coming_products[0][0] <= self.cycle:
            self.product = self.coming_products.pop(0)[1]
        while self.coming_sums and self.coming_sums[0][0] <= self.cycle:
            self.sums = self.coming_sums.pop(0)[1]
        pair = self.before, self.pc
        if pair not in self.allowed:
            if self.before is not None and i.waits_for(self.program[self.before], 1):
                raise Hazard(f"instruction {self.pc}: comes too early")
            self.allowed.add(pair)
        self.before = self.pc
        address = self._address(i)
        source = self._source(i, address, taxels)
        if i.when and self.flags[i.when >> 1 == 2] == bool(i.when & 1):  # bit 0 negates, the others name the flag
            return address, None
        if i.op in (Op.SHIFT, Op.LENGTH):
            self.t, self.k = 2 * source.bit_length() - (source > 0) if i.op == Op.LENGTH else self._shifted(source), 0
            return address, self.t
        if i.op == Op.MUL:
            if wrap(source, self.sizes.multiplicand) != source:
                raise Hazard(f"instruction {self.pc}: {source} is longer than a multiplicand")
            self.coming_products.append((self.cycle + isa.MUL_DELAY, wrap(source * self.y, self.sizes.word)))
        elif i.op == Op.MAC:
            self._mac(address, self.lengths[i.left])
        if i.op in isa.NO_RESULT:
            return address, None
        result = self._result(i, self._left(i), source)
        return address, None if result is None else self._deliver(i, address, result)

    def _left(self, i: Instruction) -> int:
        if i.left == Left.ZERO:
            return 0
        return (self.t + 1) >> 1 if i.left == Left.T else self.registers[i.left - Left.R0]

    def _shifted(self, source: int) -> int:
        amount = self.sh + self.sizes.reach
        if amount < 0:
            raise Hazard(f"instruction {self.pc}: shift by {self.sh}")
        value = ((source << (1 + self.sizes.reach)) >> amount) if amount < 256 else 0
        return wrap(value, self.sizes.word + 1)

    def _result(self, i: Instruction, left: int, source: int) -> int | None:
        """The result; ``None`` for a step of a division that leaves the dividend as it is."""
        if i.op in _SUMS:
            value = _SUMS[i.op](left, source)
        elif i.op == Op.FIT:
            value = min((self.t + 1) >> 1, (1 << (self.sizes.operand - 1)) - 1)
        elif i.op == Op.LIMIT:
            top = 1 << (self.sizes.result - 1)
            value = min(max(source, -top), top - 1)
            self.limited = -1 if value != source else self.limited
        else:
            value = left - source
            self.t >>= 1
            taken = value >= 0
            self.k = (2 * self.k + taken) % (1 << self.sizes.quotient)
            return value if taken else None
        if wrap(value, self.sizes.word) != value:
            raise Hazard(f"instruction {self.pc}: {value} is longer than a word")
        return value

    def _mac(self, address: int, products: int) -> None:
        if self.cycle < self.lanes_free:
            raise Hazard(f"instruction {self.pc}: sums are still running")
        self.lanes_free = self.cycle + products
        operands = [wrap(self.memory[address + j], self.sizes.operand) for j in range(products)]
        rows = [self.store[self.sp + j] for j in range(products)]
        sums = [sum(o * row[lane] for o, row in zip(operands, rows, strict=True)) for lane in range(self.sizes.lanes)]
        self.coming_sums.append((self.cycle + products + isa.MAC_DELAY, sums))
        self.sp += products

    def _deliver(self, i: Instruction, address: int, result: int) -> int:
        """Write ``result``; returns it as stored in the destination."""
        if i.flag:
            self.flags[i.flag - 1] = result < 0
        if i.dest == Dest.M:
            self.memory[address], self.word_written[address] = result, self.cycle
        elif Dest.R0 <= i.dest < Dest.R0 + isa.REGISTERS:
            self.registers[i.dest - Dest.R0] = result
        elif i.dest == Dest.P:
            result %= 1 << isa.ADDRESS_BITS
            self.pointers[i.pointer], self.pointer_written[i.pointer] = result, self.cycle
        elif i.dest == Dest.Y:
            self.y = result = wrap(result, self.sizes.multiplier)
        elif i.dest == Dest.SH:
            self.sh = result = wrap(result, self.sizes.shift)
        elif i.dest == Dest.SP:
            self.sp = result
        return result
