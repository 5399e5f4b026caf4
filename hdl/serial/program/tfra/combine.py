"""Vector updates z + s x, x as an operand (Eqs. 7, 8, 10)."""

from __future__ import annotations

from tfra.hdl.serial.isa import PRODUCT, R0, Dest, Op, Operand, Post, T, imm, mem
from tfra.hdl.serial.program.matvec import operand
from tfra.hdl.serial.program.routines import Writer

# Stages


def residuals(w: Writer) -> None:
    """e0 = d + alpha d_dep, in place of d, and e1 = d_ind + beta d_dep, in place of d_ind."""
    a, places, bits = w.assembler, w.map, w.at("bits", 4)
    operand(w, places.dependent, places.operand, bits)
    for scalar, vector in (("alpha", places.d), ("beta", places.independent)):
        a.move(Dest.Y, w.at(scalar))
        combine(w, vector, places.operand, bits)


def winner(w: Writer) -> None:
    """d = e0 + mu_ind e1 as multiplier words; e1 is the operand of the last product."""
    bits = w.at("bits", 4)
    w.assembler.move(Dest.Y, w.at("mu_ind"))
    combine(w, w.map.d, w.map.operand, bits)
    operand(w, w.map.d, w.map.operand, bits)


# Routines


def combine(w: Writer, vector: int, words: int, significant: Operand) -> None:
    """vector = vector + Y x, for x the operand ``words``; changes R0, T, SH and pointers 0 to 2."""
    w.points(p0=words, p1=vector, p2=significant.immediate)
    w.call(add_scaled)


def add_scaled(w: Writer) -> None:
    """Body of :func:`combine`: P0 at the words of x, P1 at the vector, P2 at the numbers of bits.

    A product is read while the next one begins, so one multiplication precedes all others.
    """
    a = w.assembler
    a.act(Op.MUL, mem(0, 0, Post.UP))
    with a.loop(4):
        a.move(R0, imm(w.fraction + w.operand - 1))
        a.sub(Dest.SH, R0, mem(0, 2, Post.UP))
        with a.loop(w.quads):
            a.act(Op.MUL, mem(0, 0, Post.UP))
            a.act(Op.SHIFT, PRODUCT)
            a.add(mem(0, 1, Post.UP), T, mem(0, 1, Post.UP))
