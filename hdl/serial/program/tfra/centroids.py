"""Direction of the tangential force from the centroids of compression and traction (Eqs. 11, 19-22)."""

from tfra.hdl.serial.isa import R0, R1, R2, R3, R4, ZERO, Dest, Op, When, imm
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.fixed.tfra.centroids import pitch_ratio


def centroids(w: TfraWriter) -> None:
    """c - t in R0 and R1, in taxels and then in the ratio of the pitches."""
    a = w.assembler
    a.move(Dest.Y, w.at("sum_c"))
    w.multiply_all((R0, w.at("u_t")), (R1, w.at("v_t")))
    a.move(Dest.Y, w.at("sum_t"))
    w.multiply_all((R2, w.at("u_c")), (R3, w.at("v_c")))
    a.sub(R0, R0, R2)
    a.sub(R1, R1, R3)
    w.normalise([R0, R1], w.division, w.at("scratch"))
    for word, ratio in zip((R0, R1), pitch_ratio(w.design), strict=True):
        if ratio > 1:
            a.move(Dest.Y, w.const(ratio))
            w.multiply_all((word, word))


def direction(w: TfraWriter) -> None:
    """cos and sin, which axis is swept, and on which side (Fig. 3), from c - t in R0 and R1."""
    a = w.assembler
    a.op(Op.ABS, R2, ZERO, R0)
    a.op(Op.ABS, R3, ZERO, R1)
    a.op(Op.SUB, R4, R2, R3, flag=1)
    a.move(w.at("sweep_y"), R4)
    a.move(R4, R0)
    a.move(R4, R1, When.F0)
    a.move(w.at("negative"), R4)
    a.add(R2, R2, R3)
    a.add(R2, R2, imm(-1))
    a.move(w.at("no_direction"), R2)
    w.normalise([R0, R1], w.operand, w.at("scratch"))
    w.set_flag(0, w.at("no_direction"))
    a.move(R0, w.const((1 << (w.operand - 1)) - 1), When.F0)
    a.move(w.at("cos"), R0)
    a.move(w.at("sin"), R1)
