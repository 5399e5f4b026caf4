"""The first words of a result, and its status word (:mod:`tfra.model.fixed.words`)."""

from __future__ import annotations

from tfra.hdl.serial.isa import LIMITED, NOTHING, R0, R1, ZERO, Dest, Left, Op, Operand, When, imm
from tfra.hdl.serial.program.routines import Writer
from tfra.model.fixed.layout import COUNTER_BITS
from tfra.model.tfra import Status


def header(w: Writer) -> None:
    """Counter, exponent, index, phi and the coefficients of friction."""
    a = w.assembler
    a.move(R0, w.at("counter"))
    a.move(Dest.OUT, R0)
    a.add(R0, R0, imm(1))
    a.op(Op.AND, R0, R0, w.const((1 << COUNTER_BITS) - 1))
    a.move(w.at("counter"), R0)
    for name in ("exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y"):
        a.move(Dest.OUT, w.at(name))


def status(w: Writer) -> None:
    """Status bits of the frame, collected in R0; F1 means that it is regular."""
    a = w.assembler
    w.set_flag(0, w.at("contact"))
    w.set_flag(1, w.at("regular"))
    a.move(R0, imm(Status.NO_CONTACT))
    a.move(R0, imm(Status.COMPRESSION_ONLY), When.F0)
    a.move(R0, NOTHING, When.F1)
    _add(w, Status.NO_DIRECTION, ZERO, w.at("no_direction"), When.F1)
    a.move(R1, imm(-1))
    _add(w, Status.VANISHING_DENOMINATOR, R1, w.at("determined"), When.F1)
    _add(w, Status.DEPENDENT_OUT_OF_RANGE, ZERO, w.at("out_of_range"), When.F1)
    _add(w, Status.INPUT_SATURATED, ZERO, w.at("input_saturated"))
    a.move(R1, imm(-1))
    a.sub(R1, R1, w.at("limits_kept"))
    a.op(Op.AND, Dest.NONE, R1, w.at("contact"), flag=1)
    a.move(R1, LIMITED)
    a.move(R1, imm(-1), When.F0)
    _add(w, Status.OUTPUT_SATURATED, ZERO, R1)
    a.move(Dest.LAST, R0)


def _add(w: Writer, bit: Status, left: Operand | Left, fact: Operand, when: When = When.ALWAYS) -> None:
    """Add ``bit`` to R0 if the fact holds and ``when``, which is F1, does; with R1 = -1 as ``left``, if it does not.

    -1 - fact is negative where the fact, a negative word, does not hold.
    """
    a = w.assembler
    w.assembler.sign(0, left, fact, Op.ADD if left == ZERO else Op.SUB)
    a.move(R1, NOTHING)
    a.move(R1, imm(bit), When.F0)
    a.add(R0, R0, R1, when)
