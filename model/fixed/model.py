"""What the bit-accurate models of all estimators share: frames some at a time, words and stages of each part."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design, FixedResult

Trace = TypeVar("Trace")
"""Results of every block for some frames."""

_CHUNK = 512  # frames at once: bounds memory, and keeps their vectors in a cache


class FixedModel(ABC, Generic[Trace]):
    """Bit-accurate model of one design."""

    def __init__(self, design: Design) -> None:
        self.design = design

    def __call__(self, codes: Ints, first_frame: int = 0) -> FixedResult:
        """Result words of converter ``codes (n, rows, columns)``; frames count from ``first_frame``."""
        parts = [(words, self._stages(trace, words)) for trace, words in self._numbered(codes, first_frame)]
        words, stages = zip(*parts, strict=True)
        return FixedResult(np.concatenate(words), stages)

    def words(self, codes: Ints) -> Ints:
        """Only the result words, in less time and memory."""
        return np.concatenate([words for _, words in self._numbered(codes, 0)])

    def _numbered(self, codes: Ints, first: int) -> Iterator[tuple[Trace, Ints]]:
        for trace in self.traces(codes):
            words = self._words(trace, first)
            first += len(words)
            yield trace, words

    def traces(self, codes: Ints) -> Iterator[Trace]:
        """Results of every block for converter ``codes (n, rows, columns)``, some frames at a time."""
        flat = np.asarray(codes, dtype=np.int64).reshape(-1, self.design.sensor.taxels)
        for start in range(0, max(1, len(flat)), _CHUNK):
            yield self._trace(flat[start : start + _CHUNK])

    @abstractmethod
    def _trace(self, codes: Ints) -> Trace:
        """Results of every block for ``codes (n, m)``."""

    @abstractmethod
    def _words(self, trace: Trace, first_frame: int) -> Ints:
        """Result words ``(n, frame_words)``; the first frame has the number ``first_frame``."""

    @abstractmethod
    def _stages(self, trace: Trace, words: Ints) -> Mapping[str, Ints]:
        """Output stream of every block: the frame first, the words of a transfer last."""
