"""Word lengths and data memory of TFRA's program, and the writer that knows them."""

from tfra.hdl.serial import sizes as shared
from tfra.hdl.serial.program.memory import MemoryMap, padded
from tfra.hdl.serial.program.routines import Writer
from tfra.hdl.serial.sizes import Sizes, lane_count
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


class TfraMap(MemoryMap):
    """Words that are no longer used are reused; vectors have Q words for each parity.

    ===============  =======================================  =========================================
    words            hold first                               hold then
    ===============  =======================================  =========================================
    ``operand``      the operand of the current product
    ``weights``      n as an operand
    ``stress``       codes, normalised in place
    ``d``            b, then d0, e0 and d                     taxels of a plane of forces
    ``independent``  d_ind, then e1                           ``p``, by taxels
    ``result``       C33^-1 b, then n; normal product of e0   q, by taxels; A-dagger d of a plane
    ``dependent``    d_dep, then the normal product of e1     ``tables`` of the sweep
    ``g``            C33 n                                    ``tables``
    ``sums_b``       sums of A-dagger b                       ``tables``
    ``sums_n``       sums of n, then A_pq
    ===============  =======================================  =========================================
    """

    def __init__(self, design: Design) -> None:
        super().__init__()
        vector, spill = 4 * design.quads, lane_count(design) - 1
        taxels, table = design.sensor.taxels, 1 << sweep_bits(design)  # a division's quotient can't leave a table
        self.operand, self.weights = self.reserve(vector), self.reserve(vector)
        self.operands = self.end
        self.stress = self.reserve(taxels)
        self.d, self.p = self.reserve(vector), self.reserve(max(vector + spill, taxels))
        self.independent = self.p
        self.result = self.reserve(max(vector + spill, taxels))
        tables = self.end
        self.dependent, self.g = self.reserve(vector + spill), self.reserve(vector + spill)
        sums_b, sums_n = (4 * padded(design, name) for name in ("sums_b", "sums_n"))
        self.sums_b = self.reserve(sums_b)
        self.reserve(max(0, tables + 4 * table - self.end))
        self.tables = [tables + number * table for number in range(4)]
        self.sums_n = self.reserve(sums_n)


class TfraWriter(Writer):
    """A writer with the memory of TFRA."""

    map: TfraMap

    def __init__(self, design: Design) -> None:
        super().__init__(design, TfraMap(design), sizes(design))
