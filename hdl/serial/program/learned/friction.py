"""Direction and friction of the resultant (:mod:`tfra.model.fixed.learned.friction`)."""

from tfra.hdl.serial.isa import R0, R1, R2, R3, R5, ZERO, Dest, Op, Operand, When, imm
from tfra.hdl.serial.program.cordic import ROUNDING, direction
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.model.fixed.gain import gain_constants
from tfra.model.fixed.widths import MU_LIMIT


def angle(w: LearnedWriter) -> None:
    """phi, zero where there is no tangential force, and the modulus of that force times the CORDIC gain."""
    a, (x, y, _) = w.assembler, w.axes("total")
    a.op(Op.ABS, R2, ZERO, x)
    a.op(Op.ABS, R2, R2, y)
    a.add(R2, R2, imm(-1))
    a.move(w.at("no_direction"), R2)
    a.move(R0, x)
    a.move(R1, y)
    a.move(R2, w.const(ROUNDING))
    direction(w, w.at("no_direction"), When.F1)
    a.move(w.at("modulus"), R0)


def friction(w: LearnedWriter) -> None:
    """mu, mu_x and mu_y; the normal force gets the CORDIC gain for mu, which the modulus has, too."""
    a, (x, y, z) = w.assembler, w.axes("total")
    first_gain, _ = gain_constants(w.design)
    a.move(R5, imm(-1))
    a.move(Dest.Y, w.const(first_gain))
    a.move(Dest.SH, imm(w.operand - 2))
    a.op(Op.ABS, R1, ZERO, z)
    w.multiply_all((R1, R1))
    w.shift(R1, R1)
    _quotient(w, "mu", w.at("modulus"))
    for name, force in (("mu_x", x), ("mu_y", y)):
        a.op(Op.ABS, R1, ZERO, z)
        _quotient(w, name, force)
    a.move(w.at("limits_kept"), R5)


def _quotient(w: LearnedWriter, name: str, force: Operand) -> None:
    """The word ``name`` = force / R1 as a scalar, limited to the longest one; zero for no force.

    R5 stays negative as long as all quotients are less than ``MU_LIMIT``.  One that is too long, or by zero, comes from
    the division as ones, and is limited.
    """
    a, top = w.assembler, (1 << (w.operand - 1)) - 1
    a.move(R3, force)
    a.move(Dest.SH, imm(-(MU_LIMIT.bit_length() - 1)))
    a.op(Op.ABS, R0, ZERO, R3)
    w.shift(R2, R1)
    a.sub(R2, R0, R2)
    a.sign(0, R0, imm(1))
    a.move(R1, imm(1), When.F0)
    a.move(R2, imm(-1), When.F0)
    a.op(Op.AND, R5, R5, R2)
    w.divide(w.fraction)
    w.least(R0, top)
    w.take_sign(R0, R3)
    a.move(w.at(name), R0)
