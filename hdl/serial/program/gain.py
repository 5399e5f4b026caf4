"""|F*|, mu and the gain F_sens / |F*| (Eqs. 15, 29-31).  From the factors on, F1 means that the frame is regular."""

from tfra.hdl.serial.isa import FLOOR, MUL_DELAY, NOTHING, PRODUCT, R0, R1, R2, R3, R4, R5, ZERO, Dest, Op, When, imm
from tfra.hdl.serial.program.cordic import cordic
from tfra.hdl.serial.program.routines import Writer
from tfra.model.fixed.gain import gain_constants, normal_gain
from tfra.model.fixed.widths import MU_LIMIT, force_drop


def modulus(w: Writer) -> None:
    """Tangential and whole modulus of F*, from two runs of the CORDIC; the second gets F*_z times the first's gain."""
    a, (x, y, z), (first_gain, _) = w.assembler, w.axes("total"), gain_constants(w.design)
    a.op(Op.ABS, R0, ZERO, x)
    a.op(Op.ABS, R1, ZERO, y)
    cordic(w)
    a.move(w.at("tangential"), R0)
    a.move(Dest.Y, w.const(first_gain))
    a.op(Op.ABS, R1, ZERO, z)
    a.act(Op.MUL, R1)
    a.move(Dest.SH, imm(w.operand - 2))
    a.nop(MUL_DELAY - 2)
    w.shift(R1, PRODUCT)
    a.move(w.at("normal"), R1)
    cordic(w)
    a.move(w.at("modulus"), R0)


def gain(w: Writer) -> None:
    """Mantissa, in R0, and exponent, in R4, of the gain: a quotient of numbers normalised to their top bits.

    R5 is negative, at the end, if the modulus is not zero.
    """
    a, (_, second_gain) = w.assembler, gain_constants(w.design)
    a.move(Dest.Y, w.const(second_gain))
    w.multiply_all((R1, w.at("magnitude")))
    w.length(R2, R1)
    w.length(R3, R0)
    a.move(R4, w.const(2 * w.operand - 4))
    a.add(R4, R4, R3)
    a.sub(R4, R4, R2)
    a.sub(Dest.SH, R2, imm(w.division))
    a.sub(R4, R4, w.at("total_exponent"))
    a.act(Op.SHIFT, R1)
    a.sub(Dest.SH, R3, imm(w.division))
    a.move(R0, FLOOR)
    w.shift(R1, w.at("modulus"))
    w.divide(w.operand - 1)
    longest, (mantissa, exponent) = (1 << w.operand) - 1, normal_gain(w.design)
    w.least(R0, longest)
    a.op(Op.SUB, R5, ZERO, w.at("modulus"), flag=1)
    a.move(R0, w.const(longest), When.NOT_F0)
    w.set_flag(1, w.at("regular"))
    a.move(R0, w.const(mantissa), When.NOT_F1)
    a.move(R4, w.const(exponent), When.NOT_F1)


def factors(w: Writer) -> None:
    """The mantissa, in R0, where a frame keeps its normal, or tangential, forces; zero elsewhere."""
    a = w.assembler
    w.set_flag(0, w.at("contact"))
    a.move(R0, NOTHING, When.NOT_F0)
    a.move(w.at("normal_factor"), R0)
    a.move(R0, NOTHING, When.NOT_F1)
    a.move(w.at("tangential_factor"), R0)


def shifts(w: Writer) -> None:
    """Shifts of forces and resultant to the grid of results, from the exponent in R4; negative ones are limited.

    R5 collects the facts that no limit applied: the modulus is not zero, mu is bounded, no shift is negative.
    """
    a, grid = w.assembler, w.design.formats.force_fraction
    a.move(Dest.SH, imm(-(MU_LIMIT.bit_length() - 1)))
    a.move(R3, w.at("normal"))
    w.shift(R3, R3)
    a.move(R2, w.at("tangential"))
    a.sub(R2, R2, R3)
    a.move(w.at("bounded"), R2)
    a.op(Op.AND, R5, R5, R2)
    a.move(R5, imm(-1), When.NOT_F1)
    a.add(R0, R4, w.const(2 - force_drop(w.design) - grid))
    a.add(R1, R4, w.at("total_exponent"))
    a.add(R1, R1, w.const(-grid))
    for name, word in (("force_shift", R0), ("resultant_shift", R1)):
        a.move(R2, imm(-1))
        a.sub(R2, R2, word)
        a.op(Op.PLUS, word, ZERO, word)
        a.op(Op.AND, R5, R5, R2)
        a.move(w.at(name), word)
    a.move(w.at("limits_kept"), R5)


def mu(w: Writer) -> None:
    """mu = tangential / normal, limited; zero where nothing is swept."""
    a, top = w.assembler, (1 << (w.operand - 1)) - 1
    a.move(R0, w.at("tangential"))
    a.move(R1, w.at("normal"))
    w.divide(w.fraction)
    w.least(R0, top)
    w.set_flag(0, w.at("bounded"))
    a.move(R0, w.const(top), When.NOT_F0)
    a.move(R0, NOTHING, When.NOT_F1)
    a.move(w.at("mu"), R0)
