"""The products of TFRA up to the sweep (Eqs. 6, 9, 10)."""

from __future__ import annotations

from tfra.hdl.serial.isa import R0, Post, When, mem, pointer
from tfra.hdl.serial.program.matvec import operand, product
from tfra.hdl.serial.program.memory import padded
from tfra.hdl.serial.program.tfra.memory import TfraWriter


def contact(w: TfraWriter) -> None:
    """C33^-1 b, and the sums of A-dagger b."""
    bits = w.at("bits", 4)
    operand(w, w.map.d, w.quads, w.map.operand, bits)
    w.points(p2=w.map.result)
    product(w, "c33_inv", w.map.operand, bits, w.quads)
    w.points(p2=w.map.sums_b)
    product(w, "sums_b", w.map.operand, bits, padded(w.design, "sums_b"))


def residual(w: TfraWriter) -> None:
    """g = C33 n; -C31 n and -C32 n by their roles in the sweep; the other sums; d = b + g."""
    a, places, bits = w.assembler, w.map, w.at("bits_n", 4)
    w.points(p2=places.g)
    product(w, "c33", places.weights, bits, w.quads)
    w.set_flag(0, w.at("sweep_y"))
    for name, dependent, independent in (("c31", When.F0, When.NOT_F0), ("c32", When.NOT_F0, When.F0)):
        a.move(pointer(2), w.address(places.dependent), dependent)
        a.move(pointer(2), w.address(places.independent), independent)
        product(w, name, places.weights, bits, w.quads)
    w.points(p2=places.sums_n)
    product(w, "sums_n", places.weights, bits, padded(w.design, "sums_n"))
    w.points(p0=0)
    with a.loop(4 * w.quads):
        a.move(R0, mem(places.g, 0))
        a.add(mem(places.d, 0, Post.UP), R0, mem(places.d, 0, Post.UP))


def normal(w: TfraWriter) -> None:
    """C33 A-dagger_3 of e0, and of e1."""
    places, bits = w.map, w.at("bits", 4)
    for vector, result in ((places.d, places.result), (places.independent, places.dependent)):
        operand(w, vector, w.quads, places.operand, bits)
        w.points(p2=result)
        product(w, "normal", places.operand, bits, w.quads)
