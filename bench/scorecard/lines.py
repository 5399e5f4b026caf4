"""The lines of the scorecard, in their order."""

from bench.scorecard import lint, overflow, proofs, reproducible
from bench.scorecard.line import Line
from bench.scorecard.upsets import measure as upsets
from bench.scorecard.words import measure as words

LINES = (
    words.LINE,
    Line(2, "words of the netlist of each preset equal those of its Verilog", "every preset, 0 differ"),
    proofs.LINE,
    overflow.LINE,
    Line(5, "wrong changes of gateware and model that tests notice", "1,000 changes of the Verilog, all noticed"),
    Line(6, "coverage of the sources and of the Verilog", "every line and branch, or told why not"),
    upsets.LINE,
    Line(8, "faults of sensor and streams that are told", "all told"),
    Line(9, "bound on the error of fixed point by proof", "proven for every preset"),
    Line(10, "hostile inputs, kills, concurrent writers, sanitisers, fuzzing", "no crash, nothing half-written"),
    reproducible.LINE,
    lint.LINE,
)
