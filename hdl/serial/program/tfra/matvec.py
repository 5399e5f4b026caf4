"""The products of TFRA up to the sweep (Eqs. 6, 9, 10)."""

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
    a, memory, bits = w.assembler, w.map, w.at("bits_n", 4)
    w.points(p2=memory.g)
    product(w, "c33", memory.weights, bits, w.quads)
    w.set_flag(0, w.at("sweep_y"))
    for name, dependent, independent in (("c31", When.F0, When.NOT_F0), ("c32", When.NOT_F0, When.F0)):
        a.move(pointer(2), w.address(memory.dependent), dependent)
        a.move(pointer(2), w.address(memory.independent), independent)
        product(w, name, memory.weights, bits, w.quads)
    w.points(p2=memory.sums_n)
    product(w, "sums_n", memory.weights, bits, padded(w.design, "sums_n"))
    w.points(p0=0)
    with a.loop(4 * w.quads):
        a.move(R0, mem(memory.g, 0))
        a.add(mem(memory.d, 0, Post.UP), R0, mem(memory.d, 0, Post.UP))


def normal(w: TfraWriter) -> None:
    """C33 A-dagger_3 of e0, and of e1."""
    memory, bits = w.map, w.at("bits", 4)
    for vector, result in ((memory.d, memory.result), (memory.independent, memory.dependent)):
        operand(w, vector, w.quads, memory.operand, bits)
        w.points(p2=result)
        product(w, "normal", memory.operand, bits, w.quads)
