"""The status word of TFRA."""

from tfra.hdl.serial.isa import NOTHING, R0, When, imm
from tfra.hdl.serial.program import words
from tfra.hdl.serial.program.tfra.memory import TfraWriter
from tfra.model.tfra import Status


def status(w: TfraWriter) -> None:
    """Status bits of the frame, collected in R0; F1 means that it is regular."""
    a = w.assembler
    w.set_flag(0, w.at("contact"))
    w.set_flag(1, w.at("regular"))
    a.move(R0, imm(Status.NO_CONTACT))
    a.move(R0, imm(Status.COMPRESSION_ONLY), When.F0)
    a.move(R0, NOTHING, When.F1)
    words.status(
        w,
        (Status.NO_DIRECTION, "no_direction", True),
        (Status.VANISHING_DENOMINATOR, "determined", False),
        (Status.DEPENDENT_OUT_OF_RANGE, "out_of_range", True),
    )
