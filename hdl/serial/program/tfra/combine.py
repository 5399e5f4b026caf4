"""Residuals of all candidates, and of the winner (Eqs. 7, 8)."""

from tfra.hdl.serial.isa import Dest
from tfra.hdl.serial.program.combine import combine
from tfra.hdl.serial.program.matvec import operand
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def residuals(w: TfraWriter) -> None:
    """e0 = d + alpha d_dep, in place of d, and e1 = d_ind + beta d_dep, in place of d_ind."""
    a, memory, bits = w.assembler, w.map, w.at("bits", 4)
    operand(w, memory.dependent, w.quads, memory.operand, bits)
    for scalar, vector in (("alpha", memory.d), ("beta", memory.independent)):
        a.move(Dest.Y, w.at(scalar))
        combine(w, vector, memory.operand, bits)


def winner(w: TfraWriter) -> None:
    """d = e0 + mu_ind e1 as multiplier words; e1 is the operand of the last product."""
    bits = w.at("bits", 4)
    w.assembler.move(Dest.Y, w.at("mu_ind"))
    combine(w, w.map.d, w.map.operand, bits)
    operand(w, w.map.d, w.quads, w.map.operand, bits)
