"""Vector updates z + s x, x as an operand (Eqs. 7, 8, 10)."""

from tfra.hdl.serial.isa import PRODUCT, R0, Dest, Op, Operand, Post, T, imm, mem
from tfra.hdl.serial.program.routines import Writer


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
