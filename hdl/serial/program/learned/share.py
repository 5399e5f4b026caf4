"""The resultant, shared among the taxels (:mod:`tfra.model.fixed.learned.share`)."""

from tfra.hdl.serial.isa import NOTHING, R0, R1, R2, R3, R4, ZERO, Dest, Op, Post, When, imm, mem
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.hdl.serial.program.scaling import plane_words
from tfra.model.fixed.learned.share import even_word


def share(w: LearnedWriter) -> None:
    """The mantissa of each axis, and the shift of all forces; p is even where its sum is too small to tell anything.

    R0 is the sum of p, R2 its length, R3 the shift; F0 says that p is even.
    """
    a, fmt, taxels, even = w.assembler, w.design.formats, w.design.sensor.taxels, even_word(w.design)
    grid = w.operand - 2 + fmt.vector_fraction - fmt.force_fraction
    a.move(R0, NOTHING)
    w.points(p0=w.map.p, p1=w.map.p)
    for _ in a.unrolled(taxels):
        a.add(R0, R0, mem(0, 0, Post.UP))
    w.length(R2, R0)
    a.move(R4, w.at("significant"))
    a.sub(R3, R2, R4)
    a.add(R3, R3, imm(grid))
    a.sign(0, R0, imm(1))
    a.move(R3, imm(-1), When.F0)
    w.set_flag(0, R3)
    a.move(R0, w.const(taxels * even), When.F0)
    a.move(R2, imm((taxels * even).bit_length()), When.F0)
    a.sub(R3, R2, R4)
    a.add(R3, R3, imm(grid))
    a.move(w.at("force_shift"), R3)
    a.sub(Dest.SH, R2, imm(w.division))
    a.move(R4, w.const(even))
    for _ in a.unrolled(taxels):
        a.move(mem(0, 1, Post.UP), R4, When.F0)
    w.shift(R4, R0)
    for word, mantissa in zip(w.axes("total"), w.axes("mantissa"), strict=True):
        a.op(Op.ABS, R0, ZERO, word)
        a.move(R1, R4)
        w.divide(w.operand - 1)
        w.least(R0, (1 << (w.operand - 1)) - 1)
        a.op(Op.ADD, R1, ZERO, word, flag=1)
        a.sub(R0, ZERO, R0, When.F0)
        a.move(mantissa, R0)


def forces(w: LearnedWriter) -> None:
    """The three planes of forces, one after the other."""
    a = w.assembler
    for mantissa in w.axes("mantissa"):
        a.move(R0, mantissa)
        a.move(w.at("factor"), R0)
        w.call(plane_words, w.map.p)
