"""The block exponent of a frame, its kind, and the normalised stress (Eq. 29)."""

from tfra.hdl.serial.isa import R0, R1, R2, R5, ZERO, Dest, Op, Post, When, imm, mem
from tfra.hdl.serial.program.butterfly import butterfly, each_quad, mirrors, quad
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def normaliser(w: TfraWriter) -> None:
    """Exponent, sums on the normalised grid, contact and regular; normalises the codes in place.

    R5 has the bit length of the largest code, F0 says that no code reaches the contact threshold.
    """
    a, top = w.assembler, w.design.adc.bits - 1
    a.move(R0, imm(top))
    a.sub(R0, R0, R5)
    a.move(w.at("exponent"), R0)
    a.sub(Dest.SH, R5, imm(top))
    a.move(R1, w.at("sum_c"))
    a.add(R1, R1, w.at("sum_t"))
    w.shift(w.at("magnitude"), R1)
    w.shift(w.at("traction_sum"), w.at("sum_t"))
    a.sub(R2, ZERO, w.at("sum_t"))
    a.sub(R1, ZERO, w.at("sum_c"), When.NOT_F0)  # else R1 is a sum of magnitudes, not negative: no contact
    a.move(w.at("contact"), R1)
    a.op(Op.AND, w.at("regular"), R1, R2)
    a.sub(Dest.SH, R5, imm(top + w.design.formats.vector_fraction))
    w.points(p0=w.map.stress)
    with a.loop(w.design.sensor.taxels):
        a.act(Op.SHIFT, mem(0, 0))
        a.rounded(mem(0, 0, Post.UP))


def fold(w: TfraWriter) -> None:
    """b, folded: four parities of every quad of mirror taxels."""
    with each_quad(w, w.map.stress):
        butterfly(w, mirrors(), quad(w.map.d, w.quads, 4))
