"""Weights of the compressive solution, n = -min(0, C33^-1 b) (Eq. 9)."""

from tfra.hdl.serial.isa import R2, R5, ZERO, Dest, Op, Post, When, imm
from tfra.hdl.serial.program.butterfly import QUAD, butterfly, butterfly_of_registers, quad
from tfra.hdl.serial.program.matvec import operand
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def weights(w: TfraWriter) -> None:
    """n, folded, in place of C33^-1 b, and as multiplier words; frames that are not swept keep both signs."""
    a, result = w.assembler, w.map.result
    w.set_flag(1, w.at("regular"))
    a.move(Dest.SH, imm(2))
    w.points(p4=0)
    with a.loop(w.quads):
        butterfly(w, quad(result, w.quads, 4, Post.KEEP), QUAD)
        for word in QUAD:
            w.round_shift(word, word)
        for word in QUAD:
            a.op(Op.LESS, word, ZERO, word, When.F1)
            a.sub(word, ZERO, word, When.NOT_F1)
        butterfly_of_registers(w, QUAD, (R2, R5), quad(result, w.quads, 4))
    operand(w, result, w.quads, w.map.weights, w.at("bits_n", 4))
