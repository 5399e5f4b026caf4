"""Word lengths of TFRA's program."""

from __future__ import annotations

from tfra.hdl.serial import sizes as shared
from tfra.hdl.serial.sizes import Sizes
from tfra.model.fixed.design import Design


def sizes(design: Design) -> Sizes:
    """Sizes of ``design``; a word is as long as the longest value that a stage of a frame stores in one."""
    w, fmt = design.widths, design.formats
    return shared.sizes(
        design,
        word=max(
            w.direction,
            max(w.b_xy, w.b_z) + 2,
            w.candidate + 2,
            w.force + fmt.operand + 2,
            w.magnitude + fmt.operand + 1,
        ),
        multiplicand=max(w.vector + 1, w.force, w.moment + 1, w.stress + fmt.vector_fraction),
        multiplier=max(w.magnitude, design.search.steps.bit_length()) + 1,
    )


def sweep_bits(design: Design) -> int:
    """Bits of a candidate's number, 0 ... K, or of their count, K + 1; unsigned."""
    return design.candidates.bit_length()
