"""The CORDIC: moduli and angles of vectors by shifts and additions."""

from __future__ import annotations

from tfra.hdl.serial.isa import FLOOR, NOTHING, R0, R1, R2, R3, R4, ZERO, Dest, Op, Post, When, imm, mem
from tfra.hdl.serial.program.routines import Writer
from tfra.model.choices import DIVISION_GUARD
from tfra.model.fixed.cordic import ANGLE_GUARD, angle_table, iterations


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


def angle(w: Writer) -> None:
    """phi = atan2(sin, cos), zero where nothing is swept (Eq. 15); vectors of the left half plane are turned by pi."""
    a, half = w.assembler, 1 << (ANGLE_GUARD - 1)
    a.move(Dest.SH, imm(-DIVISION_GUARD))
    a.move(R2, w.const(half))
    w.shift(R0, w.at("cos"))
    w.shift(R1, w.at("sin"))
    w.set_flag(0, R0)
    a.move(R2, w.const(half + (1 << (w.operand + ANGLE_GUARD - 1))), When.F0)
    a.sub(R0, ZERO, R0, When.F0)
    a.sub(R1, ZERO, R1, When.F0)
    cordic(w)
    a.move(Dest.SH, imm(ANGLE_GUARD))
    w.set_flag(1, w.at("regular"))
    w.shift(R2, R2)
    a.op(Op.AND, R2, R2, w.const((1 << w.operand) - 1))
    a.move(R2, NOTHING, When.NOT_F1)
    a.move(w.at("phi"), R2)
