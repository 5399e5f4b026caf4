"""The lines of the scorecard, in their order."""

from bench.scorecard import lint, overflow, proofs, reproducible
from bench.scorecard.hostile import measure as hostile
from bench.scorecard.line import Line
from bench.scorecard.mutants import measure as mutants
from bench.scorecard.words import measure as words

LINES = (
    words.LINE,
    Line(2, "words of the netlist of each preset equal those of its Verilog", "every preset, 0 differ"),
    proofs.LINE,
    overflow.LINE,
    mutants.LINE,
    Line(6, "coverage of the sources and of the Verilog", "every line and branch, or told why not"),
    Line(7, "upsets of registers that are told or outlived", "told for every register"),
    Line(8, "faults of sensor and streams that are told", "all told"),
    Line(9, "bound on the error of fixed point by proof", "proven for every preset"),
    hostile.LINE,
    reproducible.LINE,
    lint.LINE,
)
