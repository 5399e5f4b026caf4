"""The dependent friction mu_dep = alpha + beta mu_ind (Eqs. 12, 17, 18), with cos and sin instead of tan."""

from tfra.hdl.serial.isa import NOTHING, R0, R1, R2, R3, R4, R5, ZERO, Dest, Op, Operand, Post, T, When, imm, mem
from tfra.hdl.serial.program.memory import padded
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.tfra import COEFFICIENT_LIMIT

AXES = "xyz"


def sums(w: TfraWriter) -> None:
    """All A_pq as operand words, in place of the sums of n, and the bits they needed (Eq. 12).

    The sums of b belong to A_p0; words between the sums are zero.
    """
    a, start = w.assembler, w.map.sums_n
    for number, parity in ((0, OX), (0, OY), (2, EE)):
        a.move(R0, mem(w.map.sums_b + parity * padded(w.design, "sums_b")))
        a.add(_sum_of_n(w, number, parity), R0, _sum_of_n(w, number, parity))
    count = 4 * padded(w.design, "sums_n")
    w.points(p0=start)
    a.move(R5, NOTHING)
    with a.loop(count):
        a.op(Op.OR, R5, R5, mem(0, 0, Post.UP))
    w.length(R5, R5)
    a.move(w.at("sums_bits"), R5)
    a.sub(Dest.SH, R5, imm(w.operand - 1))
    w.points(p0=start)
    with a.loop(count):
        a.act(Op.SHIFT, mem(0, 0))
        a.op(Op.FIT, mem(0, 0, Post.UP), T, NOTHING)


def fractions(w: TfraWriter) -> None:
    """Numerators of alpha and beta, and their denominator, which is negligible where a coefficient would be too long.

    (u_0, u_x, -u_y) = sin A_x - cos A_y; the swept axis determines their roles.  F1 says, at the end, that
    alpha and beta exist and are needed.
    """
    a = w.assembler
    registers = (R0, R1, R2), (R3, R4, R5)
    for axis, name, words in zip("xy", ("sin", "cos"), registers, strict=True):
        a.move(Dest.Y, w.at(name))
        w.multiply_all(*zip(words, sum_words(w, axis), strict=True))
    for first, second in zip(*registers, strict=True):
        a.sub(first, first, second)
    w.set_flag(0, w.at("sweep_y"))
    a.sub(R3, ZERO, R2)
    a.move(R4, R1)
    a.move(R4, R3, When.F0)
    a.move(R3, R1, When.F0)
    a.sub(R0, ZERO, R0, When.F0)
    w.normalise([R0, R4, R3], w.division, w.at("scratch"))
    a.move(Dest.SH, imm(-(int(COEFFICIENT_LIMIT).bit_length() - 1)))
    a.op(Op.ABS, R1, ZERO, R3)
    w.shift(R1, R1)
    for name, word in (("numerator0", R0), ("numerator1", R4), ("denominator", R3)):
        a.move(w.at(name), word)
    a.op(Op.ABS, R5, ZERO, R4)
    a.sub(R5, R5, R1)
    a.op(Op.ABS, R2, ZERO, R0)
    a.sub(R2, R2, R1)
    a.op(Op.AND, R2, R2, R5)
    a.move(w.at("determined"), R2)
    a.op(Op.AND, R2, R2, w.at("regular"))
    w.set_flag(1, R2)


def dependent(w: TfraWriter) -> None:
    """alpha and beta; zero where the denominator is negligible or nothing is swept."""
    a = w.assembler
    for name, numerator in (("alpha", "numerator0"), ("beta", "numerator1")):
        a.op(Op.ABS, R0, ZERO, w.at(numerator))
        a.op(Op.ABS, R1, ZERO, w.at("denominator"))
        w.divide(w.fraction)
        w.set_flag(0, w.at("denominator"))
        a.move(R2, w.at(numerator))
        a.sub(R2, ZERO, R2, When.F0)
        w.take_sign(R0, R2)
        a.move(R0, NOTHING, When.NOT_F1)
        a.move(w.at(name), R0)


def sum_words(w: TfraWriter, axis: str) -> tuple[Operand, Operand, Operand]:
    """A_p0, A_px and A_py of axis p (see :func:`tfra.model.fixed.tfra.dependent.gather_sums`)."""
    sources = {
        "x": ((0, OX), (0, EE), (0, OO)),
        "y": ((0, OY), (1, OO), (1, EE)),
        "z": ((2, EE), (1, OX), (1, OY)),
    }
    first, second, third = (_sum_of_n(w, *place) for place in sources[axis])
    return first, second, third


def _sum_of_n(w: TfraWriter, number: int, parity: int) -> Operand:
    return mem(w.map.sums_n + parity * padded(w.design, "sums_n") + number)
