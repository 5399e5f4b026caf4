"""F* from the sums of the winner, before the forces (Eq. 12)."""

from tfra.hdl.serial.isa import FLOOR, NOTHING, R0, R1, R2, R3, R4, R5, Dest, Op, When, imm
from tfra.hdl.serial.program.tfra.dependent import AXES, sum_words
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def resultant(w: TfraWriter) -> None:
    """F*_p = A_p0 + mu_x A_px + mu_y A_py, with a common exponent; F*_x = F*_y = 0 where nothing is swept."""
    a, total = w.assembler, w.axes("total")
    registers = (R0, R1, R2), (R3, R4, R5)
    for column, (name, words) in enumerate(zip(("mu_x", "mu_y"), registers, strict=True), 1):
        a.move(Dest.Y, w.at(name))
        w.multiply_all(*((word, sum_words(w, axis)[column]) for axis, word in zip(AXES, words, strict=True)))
    a.move(Dest.SH, imm(-w.fraction))
    w.set_flag(1, w.at("regular"))
    for axis, word, first, second in zip(AXES, total, *registers, strict=True):
        a.add(first, first, second)
        a.act(Op.SHIFT, sum_words(w, axis)[0])
        a.add(first, first, FLOOR)
        if axis != "z":
            a.move(first, NOTHING, When.NOT_F1)
        a.move(word, first)
    w.normalise(total, w.division, w.at("scratch"))
    a.move(R0, w.const(w.operand - 1 + w.fraction + w.division - 1))
    a.sub(R0, R0, w.at("sums_bits"))
    a.sub(R0, R0, w.at("scratch"))
    a.move(w.at("total_exponent"), R0)
