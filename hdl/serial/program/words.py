"""The first words of a result, and the bits of its status word (:mod:`tfra.model.fixed.words`)."""

from itertools import takewhile

from tfra.hdl.serial.isa import LIMITED, NOTHING, R0, R1, ZERO, Dest, Left, Op, Operand, When, imm
from tfra.hdl.serial.program.routines import Writer
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.tfra import Status


def header(w: Writer) -> None:
    """Counter, and the words up to the resultant, each from the scalar of its name."""
    a = w.assembler
    a.move(R0, w.at("counter"))
    a.move(Dest.OUT, R0)
    a.add(R0, R0, imm(1))
    a.op(Op.AND, R0, R0, w.const((1 << COUNTER_BITS) - 1))
    a.move(w.at("counter"), R0)
    for field in takewhile(lambda field: field.name != "resultant", w.design.layout[1:]):
        a.move(Dest.OUT, w.at(field.name))


def status(w: Writer, *facts: tuple[Status, str, bool]) -> None:
    """The status word ends the frame; R0 has its first bits, and F1 says whether ``facts`` count.

    ``facts``: a bit, the word of its fact, and whether the fact sets the bit or its opposite.  Frames without contact
    keep no limit.
    """
    a = w.assembler
    for bit, name, holds in facts:
        if not holds:
            a.move(R1, imm(-1))
        _add_bit(w, bit, ZERO if holds else R1, w.at(name), When.F1)
    _add_bit(w, Status.INPUT_SATURATED, ZERO, w.at("input_saturated"))
    a.move(R1, imm(-1))
    a.sub(R1, R1, w.at("limits_kept"))
    a.op(Op.AND, Dest.NONE, R1, w.at("contact"), flag=1)
    a.move(R1, LIMITED)
    a.move(R1, imm(-1), When.F0)
    _add_bit(w, Status.OUTPUT_SATURATED, ZERO, R1)
    a.move(Dest.LAST, R0)


def _add_bit(w: Writer, bit: Status, left: Operand | Left, fact: Operand, when: When = When.ALWAYS) -> None:
    """Add ``bit`` to R0 if the fact holds and ``when``, which is F1, does; with R1 = -1 as ``left``, if it does not.

    -1 - fact is negative where the fact, a negative word, does not hold.
    """
    a = w.assembler
    a.sign(0, left, fact, Op.ADD if left == ZERO else Op.SUB)
    a.move(R1, NOTHING)
    a.move(R1, imm(bit), When.F0)
    a.add(R0, R0, R1, when)
