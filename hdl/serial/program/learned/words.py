"""Words of the resultant, and the status word."""

from tfra.hdl.serial.isa import NOTHING, R0, R1, R2, R3, ZERO, Dest, Op, When, imm
from tfra.hdl.serial.program import words
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.model.tfra import Status


def resultant_words(w: LearnedWriter) -> None:
    """F and its uncertainty, to the result stream."""
    a, fmt = w.assembler, w.design.formats
    a.move(Dest.SH, imm(fmt.vector_fraction - fmt.force_fraction))
    registers = (R0, R1, R2, R3)
    for register, word in zip(registers, (*w.axes("force"), w.at("uncertain")), strict=True):
        w.round_shift(register, word)
    for register in registers:
        a.op(Op.LIMIT, Dest.OUT, ZERO, register)


def status(w: LearnedWriter) -> None:
    """Status bits of the frame, collected in R0; F1 means contact."""
    a = w.assembler
    w.set_flag(1, w.at("contact"))
    a.move(R0, imm(Status.NO_CONTACT))
    a.move(R0, NOTHING, When.F1)
    words.status(w, (Status.NO_DIRECTION, "no_direction", True), (Status.IMPLAUSIBLE, "plausible", False))
