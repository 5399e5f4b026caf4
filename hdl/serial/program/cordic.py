"""The CORDIC: moduli and angles of vectors by shifts and additions."""

from tfra.hdl.serial.isa import FLOOR, NOTHING, R0, R1, R2, R3, R4, ZERO, Dest, Op, Operand, Post, When, imm, mem
from tfra.hdl.serial.program.routines import Writer
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, iterations
from tfra.model.rounding import Rounding

ROUNDING = Rounding.HALF_UP.constant(ANGLE_GUARD)
"""What an angle starts with, so that its guard bits are rounded."""


def cordic(w: Writer) -> None:
    """R0 = modulus of (R0, R1) with R0 >= 0, R2 = R2 + angle; changes R1, R3, R4, F0, pointer 0, T and SH."""
    w.call(rotations)


def rotations(w: Writer) -> None:
    """Body of :func:`cordic`: R4 counts the rotations; F0 says that y, in R1, is negative."""
    a, negative, positive = w.assembler, When.F0, When.NOT_F0
    w.points(p0=w.map.constants(*angle_table(w.design)))
    a.move(R4, imm(0))
    with a.loop(iterations(w.design)):
        a.move(Dest.SH, R4)
        w.set_flag(0, R1)
        w.shift(R3, R1)
        a.act(Op.SHIFT, R0)
        a.add(R0, R0, R3, positive)
        a.sub(R0, R0, R3, negative)
        a.sub(R1, R1, FLOOR, positive)
        a.add(R1, R1, FLOOR, negative)
        a.add(R2, R2, mem(0, 0), positive)
        a.sub(R2, R2, mem(0, 0, Post.UP), negative)
        a.add(R4, R4, imm(1))


def direction(w: Writer, fact: Operand, zero: When) -> None:
    """phi = angle of (R0, R1), zero where F1, the sign of ``fact``, is as ``zero`` says; R0 = the modulus.

    R2 is ``ROUNDING`` before.  Vectors of the left half plane are turned by pi.  Changes all registers but R5.
    """
    a = w.assembler
    w.set_flag(0, R0)
    a.move(R2, w.const(ROUNDING + (1 << (w.operand + ANGLE_GUARD - 1))), When.F0)
    a.sub(R0, ZERO, R0, When.F0)
    a.sub(R1, ZERO, R1, When.F0)
    cordic(w)
    a.move(Dest.SH, imm(ANGLE_GUARD))
    w.set_flag(1, fact)
    w.shift(R2, R2)
    a.op(Op.AND, R2, R2, w.const((1 << w.operand) - 1))
    a.move(R2, NOTHING, zero)
    a.move(w.at("phi"), R2)
