"""The resultant and its plausibility (:mod:`tfra.model.fixed.learned.resultant`)."""

from tfra.hdl.serial.isa import R0, R1, R2, ZERO, Dest, Op, imm
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION


def resultant(w: LearnedWriter) -> None:
    """F, which is in R0, R1 and R2, normalised together, in ``total``, and the bits it needed."""
    a, registers = w.assembler, (R0, R1, R2)
    w.normalise(registers, w.division, w.at("significant"))
    for word, register in zip(w.axes("total"), registers, strict=True):
        a.move(word, register)


def plausible(w: LearnedWriter) -> None:
    """Whether F presses, and its uncertainty is no larger than the threshold allows."""
    a, normal = w.assembler, w.axes("force")[2]
    a.move(Dest.Y, w.const(w.design.threshold_word))
    a.move(Dest.SH, imm(-THRESHOLD_FRACTION))
    a.op(Op.ABS, R1, ZERO, normal)
    w.multiply_all((R1, R1))
    w.shift(R0, w.at("uncertain"))
    a.sub(R0, R0, R1)
    a.add(R0, R0, imm(-1))
    a.op(Op.AND, R0, R0, normal)
    a.move(w.at("plausible"), R0)
