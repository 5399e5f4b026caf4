"""Word lengths and data memory of the learned estimator's program, and the writer that knows them."""

from tfra.hdl.serial import sizes as shared
from tfra.hdl.serial.program.memory import MemoryMap, padded
from tfra.hdl.serial.program.routines import Writer
from tfra.hdl.serial.sizes import Sizes, lane_count
from tfra.model.fixed.learned.bounds import total_bits
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION

OUTPUTS = ("direct", "read1", "read2")
"""The operators whose results add up to the outputs of the network."""


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


class LearnedMap(MemoryMap):
    """Words that are no longer used are reused; a vector has as many words for each parity as it has quads.

    ===========  ============================================  =====================
    words        hold first                                    hold then
    ===========  ============================================  =====================
    ``operand``  the operand of the current product
    ``stress``   codes                                         ``p``, by taxels
    ``vector``   codes, folded; the units of each layer        p0, then K G_x p0
    ``outputs``  the outputs' parts, in the order of OUTPUTS
    ``still``    -K b / 4, then the folded p / 4
    ``sheared``  K G_y p0
    ===========  ============================================  =====================
    """

    def __init__(self, design: LearnedDesign) -> None:
        super().__init__()
        longest, spill = 4 * max(design.quads, *design.weights.counts), lane_count(design) - 1
        self.operand = self.reserve(longest)
        self.operands = self.end
        self.stress = self.p = self.reserve(design.sensor.taxels)
        self.vector = self.reserve(longest + spill)
        self.outputs = {name: self.reserve(4 * padded(design, name)) for name in OUTPUTS}
        if design.taxel_forces:
            self.still, self.sheared = (self.reserve(4 * design.quads + spill) for _ in range(2))


class LearnedWriter(Writer):
    """A writer with the memory of the learned estimator."""

    design: LearnedDesign
    map: LearnedMap

    def __init__(self, design: LearnedDesign) -> None:
        super().__init__(design, LearnedMap(design), sizes(design))
        self.units = design.weights.counts
