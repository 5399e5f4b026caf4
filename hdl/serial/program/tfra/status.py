"""The status word of TFRA."""

from __future__ import annotations

from tfra.hdl.serial.isa import NOTHING, R0, R1, ZERO, When, imm
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.hdl.serial.program.words import add_bit, last
from tfra.model.tfra import Status


def status(w: TfraWriter) -> None:
    """Status bits of the frame, collected in R0; F1 means that it is regular."""
    a = w.assembler
    w.set_flag(0, w.at("contact"))
    w.set_flag(1, w.at("regular"))
    a.move(R0, imm(Status.NO_CONTACT))
    a.move(R0, imm(Status.COMPRESSION_ONLY), When.F0)
    a.move(R0, NOTHING, When.F1)
    add_bit(w, Status.NO_DIRECTION, ZERO, w.at("no_direction"), When.F1)
    a.move(R1, imm(-1))
    add_bit(w, Status.VANISHING_DENOMINATOR, R1, w.at("determined"), When.F1)
    add_bit(w, Status.DEPENDENT_OUT_OF_RANGE, ZERO, w.at("out_of_range"), When.F1)
    add_bit(w, Status.INPUT_SATURATED, ZERO, w.at("input_saturated"))
    last(w)
