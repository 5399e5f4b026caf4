"""The data memory of the learned estimator's program, and the writer that knows it."""

from __future__ import annotations

from tfra.hdl.serial.isa import Operand, mem
from tfra.hdl.serial.program.learned.sizes import sizes
from tfra.hdl.serial.program.memory import MemoryMap, padded
from tfra.hdl.serial.program.routines import Writer
from tfra.hdl.serial.sizes import lane_count
from tfra.model.fixed.learned.design import LearnedDesign

OUTPUTS = ("direct", "read1", "read2")
"""The operators whose results add up to the outputs of the network."""


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

    def three(self, name: str) -> list[Operand]:
        """The three words called ``name``: x, y and z of a force."""
        start = self.map.scalar(name, 3)
        return [mem(start + axis) for axis in range(3)]
