"""mu_ind and mu_dep of the winner (Eqs. 26, 27)."""

from tfra.hdl.serial.isa import MUL_DELAY, NOTHING, PRODUCT, R0, R1, R2, R3, R4, R5, ZERO, Dest, Op, T, When, imm
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def friction(w: TfraWriter) -> None:
    """mu_ind on its grid, from the winner's number in R5; zero where nothing is swept."""
    a = w.assembler
    w.set_flag(1, w.at("regular"))
    a.move(R5, NOTHING, When.NOT_F1)
    a.move(w.at("sweep_index"), R5)
    w.set_flag(0, w.at("negative"))
    a.move(R1, w.const(w.design.search.steps))
    a.move(R0, R5)
    a.sub(R0, R1, R5, When.F0)
    w.divide(w.fraction)
    a.sub(R0, ZERO, R0, When.F0)
    a.move(R0, NOTHING, When.NOT_F1)
    a.move(w.at("mu_ind"), R0)


def dependent_friction(w: TfraWriter) -> None:
    """mu_dep = alpha + beta mu_ind, saturated to an operand, and both as mu_x and mu_y; mu_ind is in R0."""
    a, top = w.assembler, 1 << (w.operand - 1)
    a.move(Dest.Y, R0)
    a.act(Op.MUL, w.at("beta"))
    a.move(Dest.SH, imm(w.fraction))
    a.nop(MUL_DELAY - 2)
    a.act(Op.SHIFT, PRODUCT)
    a.add(R2, T, w.at("alpha"))
    w.least(R2, top - 1)
    a.sign(0, R2, w.const(-top))
    a.move(R2, w.const(-top), When.F0)
    a.op(Op.ABS, R3, ZERO, R2)
    a.move(R4, w.const(1 << w.fraction))
    a.sub(R4, R4, R3)
    a.move(w.at("out_of_range"), R4)
    w.set_flag(0, w.at("sweep_y"))
    a.move(R1, R2)
    a.move(R1, R0, When.F0)
    a.move(R0, R2, When.F0)
    a.move(w.at("mu_x"), R0)
    a.move(w.at("mu_y"), R1)
