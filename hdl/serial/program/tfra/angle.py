"""Angle of the tangential force (Eq. 15)."""

from tfra.hdl.serial.isa import R0, R1, R2, Dest, When, imm
from tfra.hdl.serial.program.cordic import ROUNDING, direction
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.choices import DIVISION_GUARD


def angle(w: TfraWriter) -> None:
    """phi = atan2(sin, cos), zero where nothing is swept."""
    a = w.assembler
    a.move(Dest.SH, imm(-DIVISION_GUARD))
    a.move(R2, w.const(ROUNDING))
    w.shift(R0, w.at("cos"))
    w.shift(R1, w.at("sin"))
    direction(w, w.at("regular"), When.NOT_F1)
