"""Word lengths of the learned estimator's program."""

from __future__ import annotations

from tfra.hdl.serial import sizes as shared
from tfra.hdl.serial.sizes import Sizes
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION


def sizes(design: LearnedDesign) -> Sizes:
    """Sizes of ``design``; a word is as long as the longest value that a stage of a frame stores in one."""
    w, fmt, threshold = design.widths, design.formats, design.threshold_word.bit_length()
    return shared.sizes(
        design,
        word=max(
            w.vector + max(threshold, THRESHOLD_FRACTION) + 1,
            w.force + fmt.operand + 2,
            total_bits(design, w) + 1,
        ),
        multiplicand=max(w.vector + 1, w.force),
        multiplier=threshold + 1,
    )
