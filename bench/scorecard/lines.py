"""The lines of the scorecard, in their order."""

from bench.scorecard import bounds, lint, overflow, proofs, reproducible
from bench.scorecard.line import Line
from bench.scorecard.words import measure as words

LINES = (
    words.LINE,
    Line(2, "words of the netlist of each preset equal those of its Verilog", "every preset, 0 differ"),
    proofs.LINE,
    overflow.LINE,
    Line(5, "wrong changes of gateware and model that tests notice", "1,000 changes of the Verilog, all noticed"),
    Line(6, "coverage of the sources and of the Verilog", "every line and branch, or told why not"),
    Line(7, "upsets of registers that are told or outlived", "told for every register"),
    Line(8, "faults of sensor and streams that are told", "all told"),
    bounds.LINE,
    Line(10, "hostile inputs, kills, concurrent writers, sanitisers, fuzzing", "no crash, nothing half-written"),
    reproducible.LINE,
    lint.LINE,
)
