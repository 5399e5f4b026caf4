"""The three planes of forces f = A-dagger d + mu n, unfolded (Eq. 28)."""

from tfra.hdl.serial.isa import R5, Dest
from tfra.hdl.serial.program.butterfly import QUAD, butterfly, each_quad, mirrors, quad
from tfra.hdl.serial.program.combine import add_scaled
from tfra.hdl.serial.program.matvec import product
from tfra.hdl.serial.program.scaling import plane_words
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.fixed.widths import force_drop

_PLANES = (("pinv1", "mu_x", "tangential"), ("pinv2", "mu_y", "tangential"), ("pinv3", None, "normal"))
"""Operator, what n is multiplied by, and the factor of the gain, of each axis."""


def forces(w: TfraWriter) -> None:
    """All planes, one after the other; in the normal one mu is -1."""
    a, memory = w.assembler, w.map
    for operator, mu, factor in _PLANES:
        w.points(p2=memory.result)
        product(w, operator, memory.operand, w.at("bits", 4), w.quads)
        a.move(Dest.Y, w.at(mu) if mu else w.const(-1 << w.fraction))
        a.move(R5, w.at(f"{factor}_factor"))
        a.move(w.at("factor"), R5)
        w.call(plane)


def plane(w: TfraWriter) -> None:
    """One plane: A-dagger d + Y n, unfolded to d, rounded, and sent."""
    a, memory = w.assembler, w.map
    w.points(p0=memory.weights, p1=memory.result, p2=w.at("bits_n", 4).immediate)
    add_scaled(w)
    a.move(Dest.SH, w.const(force_drop(w.design)))
    with each_quad(w, memory.d):
        butterfly(w, quad(memory.result, w.quads, 4), QUAD)
        for taxel, place in zip(QUAD, mirrors(), strict=True):
            w.round_shift(place, taxel)
    plane_words(w, memory.d)
