"""The layers of the network: products, activations and the sum of the outputs (:mod:`tfra.model.fixed.learned`)."""

from tfra.hdl.serial.isa import NOTHING, R0, R1, R2, R3, R5, ZERO, Op, Operand, Post, When, mem
from tfra.hdl.serial.program.butterfly import QUAD, butterfly, butterfly_of_registers, quad
from tfra.hdl.serial.program.learned.memory import OUTPUTS, LearnedWriter
from tfra.hdl.serial.program.matvec import operand, product
from tfra.hdl.serial.program.memory import operator_of, padded
from tfra.model.fixed.learned.operators import PLACES


def first(w: LearnedWriter) -> None:
    """The products of b: the outputs' part, -K b / 4 for the field, and the first layer's units."""
    a, bits = w.assembler, w.at("bits", 4)
    operand(w, w.map.vector, w.quads, w.map.operand, bits)
    a.move(R0, w.at("scale"))
    for parity in range(4):
        a.add(mem(bits.immediate + parity), R0, mem(bits.immediate + parity))
    _output(w, "direct")
    if w.design.taxel_forces:
        multiply(w, "inverse", w.map.still)
    _units(w, "first")


def second(w: LearnedWriter) -> None:
    """The products of the first layer's units: the outputs' part, and the second layer's units."""
    operand(w, w.map.vector, w.units[0], w.map.operand, w.at("bits", 4))
    _output(w, "read1")
    _units(w, "second")


def read(w: LearnedWriter) -> None:
    """The outputs' part of the second layer's units."""
    operand(w, w.map.vector, w.units[1], w.map.operand, w.at("bits", 4))
    _output(w, "read2")


def total(w: LearnedWriter) -> None:
    """F in ``force``, and in R0, R1 and R2, and its uncertainty in ``uncertain``; zero in frames without contact."""
    a = w.assembler
    w.set_flag(1, w.at("contact"))
    for register, place in zip((R0, R1, R2, R3), PLACES, strict=True):
        parts = [_place(w, name, *place) for name in OUTPUTS]
        a.move(register, parts[0])
        for part in parts[1:]:
            a.add(register, register, part)
        a.move(register, NOTHING, When.NOT_F1)
    for word, register in zip(w.axes("force"), (R0, R1, R2), strict=True):
        a.move(word, register)
    a.op(Op.PLUS, w.at("uncertain"), ZERO, R3)


def multiply(w: LearnedWriter, name: str, result: int) -> None:
    """Results of operator ``name``, for the current operand."""
    w.points(p2=result)
    product(w, name, w.map.operand, w.at("bits", 4), operator_of(w.design, name).quads)


def activation(w: LearnedWriter, sums: int, quads: int) -> None:
    """ReLU at every mirror, between two butterflies: units to ``vector``, from their ``sums``.

    Changes all registers and pointer 0.
    """
    a = w.assembler
    w.points(p0=0)
    with a.loop(quads):
        butterfly(w, quad(sums, quads, 0, Post.KEEP), QUAD)
        for word in QUAD:
            a.op(Op.PLUS, word, ZERO, word)
        butterfly_of_registers(w, QUAD, (R2, R5), quad(w.map.vector, quads, 0))


def _units(w: LearnedWriter, name: str) -> None:
    """The units of a layer, in place of its sums."""
    multiply(w, name, w.map.vector)
    activation(w, w.map.vector, operator_of(w.design, name).quads)


def _output(w: LearnedWriter, name: str) -> None:
    """A product's part of the outputs, which have no parity after the last of PLACES."""
    wanted = 1 + max(parity for _, parity in PLACES)
    w.points(p2=w.map.outputs[name])
    product(w, name, w.map.operand, w.at("bits", 4), padded(w.design, name), wanted)


def _place(w: LearnedWriter, name: str, quad: int, parity: int) -> Operand:
    """The word of an output's part."""
    return mem(w.map.outputs[name] + parity * padded(w.design, name) + quad)
