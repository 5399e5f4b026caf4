"""ReLU at every mirror, between two butterflies (:mod:`tfra.model.fixed.learned.activation`)."""

from tfra.hdl.serial.isa import R2, R5, ZERO, Op, Post
from tfra.hdl.serial.program.butterfly import QUAD, butterfly, butterfly_of_registers, quad
from tfra.hdl.serial.program.learned.memory import LearnedWriter


def activation(w: LearnedWriter, sums: int, quads: int) -> None:
    """The units of a layer, to ``vector``, from its ``sums``; changes all registers and pointer 0."""
    a = w.assembler
    w.points(p0=0)
    with a.loop(quads):
        butterfly(w, quad(sums, quads, 0, Post.KEEP), QUAD)
        for word in QUAD:
            a.op(Op.PLUS, word, ZERO, word)
        butterfly_of_registers(w, QUAD, (R2, R5), quad(w.map.vector, quads, 0))
