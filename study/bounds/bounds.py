"""Bounds on the errors of a design's signals, and the errors of its frames to compare."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar

import numpy as np

from tfra.model.arrays import Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.widths import scalar_fraction
from tfra.study.signals.instrument import Instrument, only
from tfra.study.signals.measures import Values

Kind = TypeVar("Kind", bound=Design)
Signals = dict[tuple[str, str], Floats]
"""Values ``(n, k)`` in last bits of a signal, by part of the estimator and signal."""

MARGIN = 2.0**-40
"""What float64 may be off in the reference and in a bound, as a share of a frame's largest value of the signal, and of
the bound."""


class ErrorBounds(ABC, Generic[Kind]):
    """Bounds and errors of ``design``, of frames that its instrument can compare."""

    parts: Mapping[str, tuple[str, ...]]
    """Signals by part of the estimator."""

    def __init__(self, design: Kind, inside: Instrument[Kind]) -> None:
        self.design, self.inside = design, inside
        self.scalar = 0.5 ** scalar_fraction(design)

    def traces(self, codes: Ints) -> Iterator[Any]:
        """Traces of those frames of ``codes (n, rows, columns)`` that can be compared, some at a time."""
        for trace in self.design.model.traces(codes):
            yield only(trace, self.inside.comparable(trace))

    @abstractmethod
    def bounds(self, trace: Any) -> Signals:
        """Bounds of the errors; infinite, or not a number, where there are none."""

    @abstractmethod
    def exact(self, trace: Any) -> Mapping[str, Values]:
        """Values in exact arithmetic by part, as far as float64 goes."""

    def errors(self, trace: Any) -> dict[tuple[str, str], tuple[Floats, Floats]]:
        """Magnitudes of the errors as :data:`Signals`, each with the largest exact one of every frame ``(n, 1)``."""
        words, lsb, exact = self.inside.words(trace), self.inside.last_bits(trace), self.exact(trace)
        found = {}
        for part, signals in self.parts.items():
            for name in signals:
                value = np.asarray(exact[part][name] / lsb.get(name, 1)).reshape(len(trace.codes), -1)
                error = np.abs(words[name].reshape(value.shape) - value)
                found[part, name] = error, np.abs(value).max(axis=1, keepdims=True)
        return found


def violations(bound: Floats, error: Floats, largest: Floats) -> int:
    """How many errors exceed their bound by more than float64 may be off."""
    return int(np.count_nonzero(~(error <= bound * (1 + MARGIN) + MARGIN * largest)))
