"""Intake of a frame's codes."""

from tfra.hdl.serial.isa import R0, R5
from tfra.hdl.serial.program.routines import Writer


def extremes(w: Writer) -> None:
    """Whether a code is at an end of its range, or reaches the contact threshold.

    R5 is the largest code, its sign folded away, and then its bit length; F0 says, at the end, that no code reaches the
    contact threshold.  Changes R0.
    """
    a, top = w.assembler, (1 << (w.design.adc.bits - 1)) - 1
    a.move(R0, w.const(top - 1))
    a.sub(w.at("input_saturated"), R0, R5)
    a.sign(0, R5, w.const(w.design.adc.threshold))
    w.length(R5, R5)
