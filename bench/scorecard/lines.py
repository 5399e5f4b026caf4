"""The lines of the scorecard, in their order."""

from bench.scorecard import bounds, lint, overflow, proofs, reproducible
from bench.scorecard.coverage import measure as coverage
from bench.scorecard.faults import measure as faults
from bench.scorecard.hostile import measure as hostile
from bench.scorecard.mutants import measure as mutants
from bench.scorecard.netlists import measure as netlists
from bench.scorecard.upsets import measure as upsets
from bench.scorecard.words import measure as words

LINES = (
    words.LINE,
    netlists.LINE,
    proofs.LINE,
    overflow.LINE,
    mutants.LINE,
    coverage.LINE,
    upsets.LINE,
    faults.LINE,
    bounds.LINE,
    hostile.LINE,
    reproducible.LINE,
    lint.LINE,
)
