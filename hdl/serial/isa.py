"""Instructions of the serial core.

Every instruction takes one cycle: it computes ``left op source`` and writes the result to one destination.  Its
address is a pointer plus ``immediate``; source and destination share it, so ``m[a] = left op m[a]`` is one
instruction.  The state that instructions read and write:

======  ====================================================================================================
m       data memory, words of ``Sizes.word`` bits; its lowest words are also the operands of the lanes
R0-R5   data registers
P0-P6   address pointers
T       result of SHIFT and LENGTH, with one bit below the binary point; the divisor of DIV, doubled
K       quotient of DIV, bit by bit
Y       multiplier of MUL
SH      amount of SHIFT to the right; to the left if it is negative
SP      address of the next coefficients in the store
F0, F1  flags: the sign of an earlier result
======  ====================================================================================================

Rules of the pipeline for a program (the assembler inserts pauses between consecutive instructions):

* P and K are read ``SETTLE`` instructions after they were written at the earliest, a memory word ``STORED``;
* R and T are read by the next instruction, unless that is one of ``LATE`` or the writer is DIV;
* SH is read by SHIFT, two instructions after it was written at the earliest;
* a product is available ``MUL_DELAY`` instructions after MUL, sums of products as
  many and ``MAC_DELAY`` after MAC;
* the instruction after the one that ends a loop, jumps, calls or returns is still executed: a delay slot.
"""

from dataclasses import dataclass, field
from enum import IntEnum

ADDRESS_BITS = 11
"""Bits of an address and of an immediate word."""

POINTERS, REGISTERS, LOOPS = 7, 6, 3
"""Address pointers, data registers, and how deep loops nest."""

MUL_DELAY, MAC_DELAY = 3, 6
"""Instructions from MUL to its product, and from the last product of MAC to its sums."""

SETTLE, STORED = 3, 4
"""Instructions from the one that writes a pointer or K, and a memory word, to the first that may read it."""


class Op(IntEnum):
    """Operations; those outside ``NO_RESULT`` write their result to the destination."""

    ADD = 0  # left + source
    SUB = 1  # left - source
    PLUS = 2  # left + max(source, 0)
    LESS = 3  # left - min(source, 0)
    ABS = 4  # left + |source|
    OR = 5  # left | (source ^ sign of source): collects the bits that words need beside their sign
    AND = 6  # left & source
    FIT = 7  # T rounded half up to a multiplier operand; saturates where rounding makes it too long
    LIMIT = 8  # source saturated to a result word; LIMITED becomes -1 if that changed it
    DIV = 9  # a step of a division: left - T / 2, not written if negative; K takes the quotient's bit, T is halved
    SHIFT = 10  # T = source shifted right by SH (left if negative), with one bit below the point; K = 0
    LENGTH = 11  # T, rounded, = bit length of the source; K = 0
    MUL = 12  # product = source * Y
    MAC = 13  # start the sums of products: operands from the address, coefficients from SP on; left numbers how many
    DO = 14  # the loop that starts after this instruction runs immediate + 1 times
    JUMP = 15  # jump to the immediate; a call if the left operand is R0; a return to after the last call if it is T


LATE = (Op.PLUS, Op.LESS, Op.ABS, Op.OR, Op.AND, Op.LIMIT, Op.SHIFT, Op.LENGTH, Op.MUL)
"""Operations whose source can't be the last result: there is no time after it, or they need its sign before."""

NO_RESULT = (Op.SHIFT, Op.LENGTH, Op.MUL, Op.MAC, Op.DO, Op.JUMP)
"""Operations without a destination."""


class Left(IntEnum):
    """First operand; ``T`` is rounded half up, for ADD and FIT only.  Registers start at ``R0``."""

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
    SUM = 10  # sum of the next lane, in the order of the lanes
    IN = 11  # the next taxel; waits for it
    K = 12
    LIMITED = 13  # -1 if LIMIT changed a word since this was read last, else 0
    NOTHING = 14  # zero


class Dest(IntEnum):
    """Where a result goes."""

    NONE = 0
    M = 1
    R0 = 2
    OUT = 8  # result stream; waits for it
    LAST = 9  # result stream, as the last word of a frame
    P = 10  # the pointer that the address names
    Y = 11
    SH = 12
    SP = 13


class Post(IntEnum):
    """What becomes of the pointer after the address was computed with it."""

    KEEP = 0
    UP = 1
    DOWN = 2
    MOVE = 3  # the pointer becomes the address


class When(IntEnum):
    """Condition under which an instruction acts; a flag is true if the result that set it was negative."""

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
"""Bits of an instruction's fields, the lowest first."""

NO_POINTER = POINTERS
"""The pointer that is always zero."""


@dataclass(frozen=True)
class Instruction:
    """One word of the program.

    ``when`` is its condition, ``flag`` the flag that takes the result's sign (1: F0, 2: F1), ``end`` marks the last
    instruction but one of a loop.  ``stage`` names the part of the frame that it belongs to and is not in the word.
    """

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
    stage: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if not -(1 << (ADDRESS_BITS - 1)) <= self.immediate < 1 << ADDRESS_BITS:
            raise ValueError(f"immediate {self.immediate} is longer than {ADDRESS_BITS} bits")

    @property
    def word(self) -> int:
        """The instruction as an integer, fields as in ``FIELDS``."""
        value, place = 0, 0
        for name, bits in FIELDS.items():
            value |= (getattr(self, name) & ((1 << bits) - 1)) << place
            place += bits
        return value

    @property
    def written(self) -> int:
        """Where the result goes: ``Dest.NONE`` for operations without one."""
        return Dest.NONE if self.op in NO_RESULT else self.dest

    def waits_for(self, other: "Instruction", distance: int) -> bool:
        """Whether this one comes too early, ``distance`` instructions after ``other``."""
        # Words at pointers are known at run time only, where the interpreter looks at them.
        same_word = self.pointer == other.pointer == NO_POINTER and self.immediate == other.immediate
        reads_word = same_word and self.source == Src.M and other.written == Dest.M
        uses_pointer = other.dest == Dest.P and other.pointer == self.pointer and self.dest != Dest.P
        uses_quotient = other.op == Op.DIV and self.source == Src.K
        early = (distance < STORED and reads_word) or (distance < SETTLE and (uses_pointer or uses_quotient))
        return early or (distance == 1 and self._reads_late_result_of(other))

    def _reads_late_result_of(self, other: "Instruction") -> bool:
        """Whether ``other``'s result is on its way, past the operands that the next instruction has fetched."""
        if self.op == Op.SHIFT and other.written == Dest.SH:
            return True
        # Src and Dest number the registers alike.  After them other pairs, as SUM and P, share a number, too: such a
        # pause is not needed, but harmless.
        same = self.source == other.written >= Dest.R0
        if other.op == Op.DIV and (same or self.left == other.written):
            return True
        shifted = other.op in (Op.SHIFT, Op.LENGTH) and self.source == Src.FLOOR
        return self.op in LATE and (same or shifted)


@dataclass(frozen=True)
class Operand:
    """A source, destination or left operand; for memory also its address."""

    source: int
    pointer: int = NO_POINTER
    post: Post = Post.KEEP
    immediate: int = 0


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
