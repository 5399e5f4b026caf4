"""Bounds on the errors of a design's results, and the errors of its frames to compare."""

from collections.abc import Mapping

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import Trace
from tfra.study.bounds.candidate import CandidateBounds
from tfra.study.bounds.results import phi_bound, scaling_bounds
from tfra.study.signals.instrument import only
from tfra.study.signals.measures import Values
from tfra.study.signals.tfra.instrument import TfraInstrument

MARGIN = 2.0**-40
"""What float64 may be off in a bound and in the reference, as a share of the largest value of a frame and of a bound."""

PARTS = {
    "phi": ("phi",),
    "forces before the decision": ("n", "alpha", "beta", "e0", "e1", "p", "q", "d", "planes"),
    "scaling": ("gain", "mu", "resultant", "forces"),
}
"""Signals, by what they are a part of.  Errors of the scaling are those of its own, given the sums and the forces that
it scales; all others are from the codes on.  ``d`` and ``planes`` are of the candidate that was chosen."""


class ErrorBounds:
    """Bounds and errors of ``design``, in last bits of the signals."""

    def __init__(self, design: TfraDesign) -> None:
        self.design = design
        self._inside = TfraInstrument(design)
        self._candidate = CandidateBounds(design)

    def traces(self, codes: Ints) -> Trace:
        """The trace of those frames of ``codes (n, rows, columns)`` that are swept and whose results are not limited."""
        trace = next(self.design.model.traces(codes))
        return only(trace, self._inside.comparable(trace))

    def bounds(self, trace: Trace) -> dict[str, Floats]:
        """Bounds ``(n, k)`` by signal; infinite where the denominator of alpha and beta may vanish."""
        lsb = self._inside.last_bits(trace)
        found = {name: bound / lsb.get(name, 1) for name, bound in self._candidate(trace).items()}
        return found | scaling_bounds(self.design, trace) | {"phi": phi_bound(self.design, trace)[:, None]}

    def errors(self, trace: Trace) -> tuple[dict[str, Floats], dict[str, Floats]]:
        """Magnitudes of errors ``(n, k)`` by signal, and the largest exact magnitude of each frame ``(n, 1)``."""
        words, lsb, decided = self._inside.words(trace), self._inside.last_bits(trace), self._inside.decisions(trace)
        reference = self._inside.reference
        exact: Values = reference.from_codes(trace.codes, decided)
        given: Values = {name: word * lsb.get(name, 1) for name, word in words.items()}
        for step in reference.steps[-3:]:  # gain, angle, scaling
            given |= step(given, decided)
        exact |= {name: given[name] for name in PARTS["scaling"]}
        errors, largest = {}, {}
        for name in (name for names in PARTS.values() for name in names):
            value = (exact[name] / lsb.get(name, 1)).reshape(len(trace.codes), -1)
            errors[name] = np.abs(words[name].reshape(value.shape) - value)
            largest[name] = np.abs(value).max(axis=1, keepdims=True, initial=0.0)
        return errors, largest


def violated(bound: Floats, error: Floats, largest: Floats) -> int:
    """How many errors exceed their bound, by more than float64 may be off."""
    return int(np.count_nonzero(error > bound * (1 + MARGIN) + MARGIN * largest))
