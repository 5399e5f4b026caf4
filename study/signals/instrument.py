"""The instrument: measures of the signals inside a bit-accurate model, frame by frame; each estimator has its own."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.design import Design
from tfra.study.signals.measures import (
    REFERENCES,
    Measures,
    Observed,
    Row,
    Values,
    Word,
    errors_of,
    lengths_of,
    range_of,
    total,
)
from tfra.study.signals.stages import Stages

Kind = TypeVar("Kind", bound=Design)


class Instrument(ABC, Generic[Kind]):
    """The signals inside the bit-accurate model of ``design``, beside float64.

    ``over_array`` are the signals with a quad of words for each four mirror taxels, ``reference`` is float64.
    """

    over_array: Collection[str]
    reference: Stages

    def __init__(self, design: Kind) -> None:
        self.design = design
        one_each = to_quads(design, np.eye(design.sensor.taxels, dtype=np.int64))
        self._carries = butterfly(one_each).any(axis=0)  # on middle lines the odd parities are no words at all

    def measure(self, codes: Ints) -> Measures:
        """All measures over converter codes ``(n, rows, columns)``."""
        parts = (self.ranges, self.errors, self.flips)
        return total(part(trace) for trace in self.design.model.traces(codes) for part in parts)

    def ranges(self, trace: Any) -> Measures:
        """Use of the words of every signal of the catalogue, and their lengths."""
        observed = self.observe(trace) if len(trace.codes) else {}
        return {
            "ranges": {signal: range_of(words) for signal, words in observed.items()},
            "lengths": {signal: lengths_of(words.values) for signal, words in observed.items()},
        }

    def errors(self, trace: Any) -> Measures:
        """Errors against both references, of frames that have all stages, and whose results are within their words."""
        comparable = self.comparable(trace)
        if not comparable.any():
            return {}
        trace = only(trace, comparable)
        by_name, lsb = self.words(trace), self.last_bits(trace)
        inputs: Values = {name: word * lsb.get(name, 1) for name, word in by_name.items()}
        inputs["codes"] = trace.codes
        errors: dict[str, dict[str, Row]] = {reference: {} for reference in REFERENCES}
        for reference, values in zip(REFERENCES, self.references(trace, inputs), strict=True):
            for name, word in by_name.items():
                exact = values[name] / lsb.get(name, 1)
                error = np.asarray(word - exact, dtype=np.float64)
                if name in self.over_array:
                    exact, error = exact[:, self._carries], error[:, self._carries]
                errors[reference][name] = errors_of(exact, error)
        return errors

    @property
    @abstractmethod
    def catalogue(self) -> Mapping[str, Word]:
        """The word of every signal, in the order of the stages."""

    @abstractmethod
    def stage_of(self, signal: str) -> str:
        """The stage of ``signal``."""

    @abstractmethod
    def observe(self, trace: Any) -> Mapping[str, Observed]:
        """Every signal of the catalogue in ``trace``."""

    @abstractmethod
    def comparable(self, trace: Any) -> Bools:
        """Frames ``(n,)`` whose errors can be told."""

    @abstractmethod
    def words(self, trace: Any) -> Mapping[str, Ints]:
        """The integers that stages give each other, by name; the frame first."""

    @abstractmethod
    def last_bits(self, trace: Any) -> Mapping[str, Floats]:
        """Weight of the last bit of those of :meth:`words` where it is not 1; with the signal's number of axes."""

    @abstractmethod
    def decisions(self, trace: Any) -> Any:
        """Those of the model, which the ``reference`` takes over."""

    def references(self, trace: Any, inputs: Values) -> tuple[Values, Values]:
        """The same in float64: from the codes on, and each stage from ``inputs``, the model's own values."""
        decided = self.decisions(trace)
        return self.reference.from_codes(trace.codes, decided), self.reference.from_inputs(inputs, decided)

    @abstractmethod
    def flips(self, trace: Any) -> Measures:
        """Decisions of any frames, each compared where those before it agree."""


class Counter:
    """Counts by decision the ``frames`` that are compared, and the ``flips`` among them; ``rows`` has both."""

    def __init__(self) -> None:
        self.rows: dict[str, Row] = {}

    def __call__(self, decision: str, frames: Bools, same: Bools) -> Bools:
        """Count those of ``frames`` that are not the ``same``; return those that are."""
        self.rows[decision] = {"frames": int(frames.sum()), "flips": int((frames & ~same).sum())}
        return frames & same


def only(node: Any, keep: Bools) -> Any:
    """The frames ``keep`` of ``node``, a dataclass or a tuple of arrays with the frame first, or None."""
    if is_dataclass(node) and not isinstance(node, type):
        return replace(node, **{f.name: only(getattr(node, f.name), keep) for f in fields(node)})
    if isinstance(node, tuple):
        return tuple(only(part, keep) for part in node)
    return None if node is None else node[keep]
