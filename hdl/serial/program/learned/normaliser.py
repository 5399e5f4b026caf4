"""Intake and block exponent of a frame, and its fold.

Codes are not shifted one by one: the operand of the first product fills its words anyway, and the exponent is added to
the shift that undoes this.
"""

from tfra.hdl.serial.isa import IN, NOTHING, R0, R1, R5, ZERO, Op, Post, When, imm, mem
from tfra.hdl.serial.program.butterfly import butterfly, each_quad, mirrors, quad
from tfra.hdl.serial.program.learned.memory import LearnedWriter
from tfra.hdl.serial.program.routines import extremes


def codes(w: LearnedWriter) -> tuple[int, int, int]:
    """Store codes as they arrive; R1 adds up compression, R5 is the largest code, its sign folded away.

    Returns the cycle that takes the last code, the cycles since the first one, and those from one code to the next.
    """
    a = w.assembler
    a.move(R1, NOTHING)
    a.move(R5, NOTHING)
    w.points(p0=w.map.stress)
    taxels = w.design.sensor.taxels
    with a.loop(taxels):
        a.move(R0, IN)
        a.move(mem(0, 0, Post.UP), R0)
        a.op(Op.LESS, R1, R1, R0)
        a.op(Op.OR, R0, ZERO, R0)
        a.sign(0, R5, R0)
        a.move(R5, R0, When.F0)
        taxel = a.here
    taken = a.cycles - taxel
    extremes(w)
    return taken, (taxels - 1) * taxel, taxel


def normaliser(w: LearnedWriter) -> None:
    """Exponent and contact; ``scale`` is the shift from codes to the vector grid.

    R1 is the sum of compression, R5 the bit length of the largest code, F0 says that no code reaches the contact
    threshold.
    """
    a = w.assembler
    a.sub(R1, ZERO, R1, When.NOT_F0)
    a.move(w.at("contact"), R1)
    a.move(R0, imm(w.design.adc.bits - 1))
    a.sub(R0, R0, R5)
    a.move(w.at("exponent"), R0)
    a.add(R0, R0, imm(w.design.formats.vector_fraction))
    a.move(w.at("scale"), R0)


def fold(w: LearnedWriter) -> None:
    """The codes, folded: four parities of every quad of mirror taxels."""
    with each_quad(w, w.map.stress):
        butterfly(w, mirrors(), quad(w.map.vector, w.quads, 4))
