"""Scaling to result words, with saturation (Eq. 31)."""

from tfra.hdl.serial.isa import MUL_DELAY, PRODUCT, R0, R1, R2, ZERO, Dest, Op, Post, mem
from tfra.hdl.serial.program.routines import Writer


def resultant_words(w: Writer) -> None:
    """F times the gain, to the result stream."""
    a, factors = w.assembler, ("tangential", "tangential", "normal")
    a.move(Dest.SH, w.at("resultant_shift"))
    for register, word, factor in zip((R0, R1, R2), w.axes("total"), factors, strict=True):
        a.move(Dest.Y, w.at(f"{factor}_factor"))
        a.act(Op.MUL, word)
        a.nop(MUL_DELAY - 1)
        w.round_shift(register, PRODUCT)
    for register in (R0, R1, R2):
        a.op(Op.LIMIT, Dest.OUT, ZERO, register)


def plane_words(w: Writer, plane: int) -> None:
    """A ``plane`` of forces, by taxels, times the word ``factor``, to the result stream.

    A product takes as long as an iteration of the loop, so two multiplications precede the loop.
    """
    a = w.assembler
    w.points(p0=plane)
    a.move(Dest.Y, w.at("factor"))
    a.move(Dest.SH, w.at("force_shift"))
    a.act(Op.MUL, mem(0, 0, Post.UP))
    a.nop(MUL_DELAY - 2)
    a.act(Op.MUL, mem(0, 0, Post.UP))
    a.act(Op.SHIFT, PRODUCT)
    a.rounded(R0)
    with a.loop(w.design.sensor.taxels - 1):
        a.act(Op.MUL, mem(0, 0, Post.UP))
        a.act(Op.SHIFT, PRODUCT)
        a.op(Op.LIMIT, Dest.OUT, ZERO, R0)
        a.rounded(R0)
    a.op(Op.LIMIT, Dest.OUT, ZERO, R0)
