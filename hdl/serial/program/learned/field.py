"""Normal forces at the taxels (:mod:`tfra.model.fixed.learned.field`)."""

from tfra.hdl.serial.isa import R0, R1, ZERO, Dest, Op
from tfra.hdl.serial.program.butterfly import QUAD, butterfly, each_quad, mirrors, quad
from tfra.hdl.serial.program.combine import combine
from tfra.hdl.serial.program.learned.layers import activation, multiply
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.hdl.serial.program.matvec import operand
from tfra.model.learned.field import MOST_FRICTION


def shear(w: LearnedWriter) -> None:
    """The first pass, and its products: -K b + mu_x K G_x p0 + mu_y K G_y p0, folded, in place of -K b."""
    a, memory, bits = w.assembler, w.map, w.at("bits", 4)
    activation(w, memory.still, w.quads)
    operand(w, memory.vector, w.quads, memory.operand, bits)
    for name, result in (("shear_x", memory.vector), ("shear_y", memory.sheared)):
        multiply(w, name, result)
    for name, result in (("mu_x", memory.vector), ("mu_y", memory.sheared)):
        operand(w, result, w.quads, memory.operand, bits)
        a.move(R1, w.at(name))
        a.op(Op.ABS, R0, ZERO, w.at(name))
        w.least(R0, int(MOST_FRICTION * 2**w.fraction))
        w.take_sign(R0, R1)
        a.move(Dest.Y, R0)
        combine(w, memory.still, memory.operand, bits)


def unfold(w: LearnedWriter) -> None:
    """p at the taxels, none of it negative."""
    with each_quad(w, w.map.p):
        butterfly(w, quad(w.map.still, w.quads, 4), QUAD)
        for word, place in zip(QUAD, mirrors(), strict=True):
            w.assembler.op(Op.PLUS, place, ZERO, word)
