"""The writer of a program: named words, and the scalar routines that the stages of a frame share.

A routine's docstring names the registers that it changes besides its results.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Concatenate, ParamSpec, Self

from tfra.hdl.serial import isa
from tfra.hdl.serial.isa import FLOOR, NOTHING, PRODUCT, R0, R1, R5, ZERO, Dest, K, Op, Operand, Src, T, When, imm, mem
from tfra.hdl.serial.program.assembler import Assembler
from tfra.hdl.serial.program.memory import MemoryMap
from tfra.hdl.serial.sizes import Sizes
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction

_Arguments = ParamSpec("_Arguments")

_IMMEDIATES = range(-1024, 1024)


class Writer:
    """Writes the program of one design with ``assembler``; ``map`` has the addresses of its words.

    A fact is a word that is negative if the fact is true, so that AND and the flags work on it.
    """

    def __init__(self, design: Design, map_: MemoryMap, sizes: Sizes) -> None:
        self.design = design
        self.assembler = Assembler()
        self.map = map_
        self.sizes = sizes
        self.quads = design.quads
        self.operand = design.formats.operand
        self.fraction = scalar_fraction(design)
        self.division = design.widths.division

    # Operands

    def at(self, name: str, words: int = 1) -> Operand:
        """The word, or the first of the ``words``, called ``name``."""
        return mem(self.map.scalar(name, words))

    def const(self, value: int) -> Operand:
        """A source with ``value``: an immediate if it is short, otherwise a word of the memory."""
        return imm(value) if value in _IMMEDIATES else mem(self.map.constants(int(value)))

    def huge(self) -> Operand:
        """A source that is the largest word."""
        return self.const((1 << (self.sizes.word - 1)) - 1)

    def address(self, value: int) -> Operand:
        """A source that is the address ``value``."""
        return Operand(Src.IMM, immediate=value)

    def points(self, **values: int) -> None:
        """p0=..., p1=...: set pointers to addresses."""
        for name, value in values.items():
            self.assembler.move(isa.pointer(int(name[1:])), self.address(value))

    def axes(self, name: str) -> list[Operand]:
        """The three words called ``name``: x, y and z of a force."""
        start = self.map.scalar(name, 3)
        return [mem(start + axis) for axis in range(3)]

    def set_flag(self, flag: int, word: Operand) -> None:
        """Flag F0 or F1 = the fact ``word``."""
        self.assembler.sign(flag, ZERO, word, Op.ADD)

    def call(
        self, body: Callable[Concatenate[Self, _Arguments], None], *args: _Arguments.args, **kwargs: _Arguments.kwargs
    ) -> None:
        """Call ``body`` as a subroutine, which is written once for equal arguments."""
        self.assembler.call(" ".join((label(body), *map(str, args))), partial(body, self, *args, **kwargs))

    # Scalars

    def shift(self, dest: Operand | Dest, source: Operand) -> None:
        """dest = source >> SH, towards minus infinity; changes T."""
        self.assembler.act(Op.SHIFT, source)
        self.assembler.move(dest, FLOOR)

    def round_shift(self, dest: Operand | Dest, source: Operand) -> None:
        """dest = source >> SH, rounded half up; changes T."""
        self.assembler.act(Op.SHIFT, source)
        self.assembler.rounded(dest)

    def multiply_all(self, *pairs: tuple[Operand, Operand]) -> None:
        """Each register of ``pairs`` = its source * Y, for up to three of them."""
        for _, source in pairs:
            self.assembler.act(Op.MUL, source)
        self.assembler.nop(isa.MUL_DELAY - len(pairs))
        for register, _ in pairs:
            self.assembler.move(register, PRODUCT)

    def length(self, dest: Operand | Dest, source: Operand) -> None:
        """dest = bit length of ``source``; changes T."""
        self.assembler.act(Op.LENGTH, source)
        self.assembler.rounded(dest)

    def normalise(self, words: Sequence[Operand], bits: int, significant: Operand) -> None:
        """Shift ``words`` in place by a common shift so that they fill ``bits``; their former bits go to
        ``significant``.

        Rounding is the only thing that can make a word too long.  Changes R5, T, SH and F0.
        """
        a = self.assembler
        for number, word in enumerate(words):
            a.op(Op.OR, R5, R5 if number else ZERO, word)
        self.length(R5, R5)
        a.sub(Dest.SH, R5, imm(bits - 1))
        a.move(significant, R5)
        limit = 1 << (bits - 1)
        for word in words:
            if bits == self.operand:
                a.act(Op.SHIFT, word)
                a.op(Op.FIT, word, T, NOTHING)
            else:
                self.round_shift(R5, word)
                a.sign(0, R5, self.const(limit))
                a.move(R5, self.const(limit - 1), When.NOT_F0)
                a.move(word, R5)

    def least(self, word: Operand, limit: int) -> None:
        """word = min(word, limit); changes F0."""
        self.assembler.sign(0, word, self.const(limit))
        self.assembler.move(word, self.const(limit), When.NOT_F0)

    def take_sign(self, register: Operand, word: Operand) -> None:
        """register = -register if ``word`` is negative; changes F0."""
        self.set_flag(0, word)
        self.assembler.sub(register, ZERO, register, When.F0)

    def divide(self, fraction: int) -> None:
        """R0 = R0 / R1, both positive, with ``fraction`` bits, rounded half up; changes K, T and SH.

        The quotient is operand + 1 bits long at most.
        """
        self.assembler.move(Dest.SH, imm(-(fraction + 1)))
        self.call(quotient)


def quotient(w: Writer) -> None:
    """Body of :meth:`Writer.divide`: SH is the number of the quotient's bits, negative."""
    a, bits = w.assembler, w.operand + 2
    a.act(Op.SHIFT, R0)
    a.move(Dest.SH, imm(1 - bits))
    a.move(R0, FLOOR)
    a.act(Op.SHIFT, R1)
    with a.loop(bits):
        a.op(Op.DIV, R0, R0, FLOOR)
        a.nop()
    a.move(Dest.SH, imm(1))
    a.move(R0, K)
    w.round_shift(R0, R0)


def extremes(w: Writer) -> None:
    """Whether a code is at an end of its range, or reaches the contact threshold.

    R5 is the largest code, its sign folded away, and then its bit length; F0 says, at the end, that no code reaches the
    contact threshold.  Changes R0.
    """
    a, top = w.assembler, (1 << (w.design.adc.bits - 1)) - 1
    a.move(R0, w.const(top - 1))
    a.sub(w.at("input_saturated"), R0, R5)
    a.sign(0, R5, w.const(w.design.adc.threshold))
    w.length(R5, R5)


def label(part: Callable[..., object]) -> str:
    """Name of a part of the program: the file and the function that write it, for example ``sweep.choose``."""
    return f"{part.__module__.rpartition('.')[2]}.{part.__name__}"
