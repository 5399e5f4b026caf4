"""A design: its choices and all that follows from them, made once and passed on; what all bit-accurate models share."""

import difflib
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
import numpy.typing as npt

from tfra.model.arrays import Ints
from tfra.model.choices import SCALARS, Architecture, Choices
from tfra.model.fixed.coefficients import Stack
from tfra.model.fixed.layout import Field, make_layout
from tfra.model.fixed.widths import Widths
from tfra.model.tfra import Result, Status

Trace = TypeVar("Trace")
"""Results of every block for some frames."""

_CHUNK = 512  # frames at once: bounds memory, and keeps their vectors in a cache


@dataclass(frozen=True)
class FixedResult:
    """``words (n, frame_words)`` as the core sends them."""

    words: Ints
    parts: tuple[Mapping[str, Ints], ...]

    @property
    def stages(self) -> dict[str, Ints]:
        """What flows between blocks, by name: the first axis is the frame, then come transfers in their order."""
        return {name: np.concatenate([part[name] for part in self.parts]) for name in self.parts[0]}


def signals_of(operators: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Signals that may have a word length of their own: coefficients of each stack's operators, operands, scalars."""
    coefficients = (f"coefficient.{name}" for names in operators.values() for name in names)
    return (*coefficients, *(f"operand.{name}" for name in (*operators, "combine")), *SCALARS)


@dataclass(frozen=True)
class Design(Choices, ABC):
    """Choices with what follows from them; each subclass is an estimator, an algorithm with its operators and bounds.

    Everything is computed on first access and stays with the object; a pickled design carries its choices
    alone.  Raises ``ValueError`` for formats of signals that the estimator does not have.
    """

    estimator: ClassVar[str]
    """The estimator's name in CONFIG."""
    method: ClassVar[str]
    """What computes, as a sentence ends: "by TFRA"."""
    config_keys: ClassVar[tuple[str, ...]] = ()
    """Keys of CONFIG's ``[estimator]`` beside ``kind``: ``weights``, a file of ``tfra train``; else fields."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, _ in self.formats.signals:
            if name not in self.signals:
                nearest = difflib.get_close_matches(name, self.signals, n=1, cutoff=0)[0]
                raise ValueError(f"formats.signals.{name}: unknown signal, the nearest is {nearest}")

    @property
    @abstractmethod
    def stacks(self) -> dict[str, Stack]:
        """Quantised operators by the name of their stack, in the order of the coefficient memories."""

    @property
    @abstractmethod
    def products(self) -> tuple[str, ...]:
        """The stack of each product of a frame, in order."""

    @property
    @abstractmethod
    def signals(self) -> tuple[str, ...]:
        """Signals that may have a word length of their own in ``formats``."""

    @property
    def used_signals(self) -> tuple[str, ...]:
        """Those of ``signals`` on which a result of this design depends."""
        return self.signals

    @property
    @abstractmethod
    def result_fields(self) -> tuple[str, ...]:
        """Names of the fields of a result frame, in order."""

    @property
    @abstractmethod
    def widths(self) -> Widths:
        """Word lengths; raises ``ValueError`` that names a section where words could overflow."""

    @property
    @abstractmethod
    def model(self) -> "FixedModel[Any]":
        """The bit-accurate model: from converter codes ``(n, rows, columns)`` to result words."""

    @property
    @abstractmethod
    def float_model(self) -> Callable[[npt.ArrayLike], Result]:
        """The estimator in double precision: from stress ``(n, rows, columns)`` in Pa to results."""

    @property
    @abstractmethod
    def float_settings(self) -> tuple[Hashable, ...]:
        """Everything that the float model takes from the design beside the sensor: alike for designs that share it."""

    @property
    @abstractmethod
    def status_bits(self) -> tuple[Status, ...]:
        """Status bits that the estimator sets."""

    @property
    def facts(self) -> Mapping[str, Any]:
        """What is known of the estimator beside its name, by the sidecar's keys."""
        return {}

    @property
    def condition(self) -> float | None:
        """Condition number of the matrix that the estimator inverts; None where it inverts none or a large one."""
        return None

    @property
    def sweeps(self) -> bool:
        """Whether the estimator chooses among candidates: its frames have a sweep index."""
        return "sweep_index" in self.result_fields

    @property
    def uncertainty_threshold(self) -> float | None:
        """What a core compares the uncertainty over |F_z| with; None if the estimator has no uncertainty."""
        return None

    def built_as(self, architecture: Architecture, **choices: Any) -> Self:
        """The design in another ``architecture``, with other ``choices`` of where it goes: ``images``, ``target``.

        Operators and word lengths, which follow from none of these, are not computed again.
        """
        other = replace(self, architecture=architecture, **choices)
        for name in ("stacks", "widths"):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    @cached_property
    def layout(self) -> tuple[Field, ...]:
        """Fields of a result frame in order."""
        return make_layout(self, self.widths.output, self.result_fields)

    @property
    def frame_words(self) -> int:
        """Words of a result frame."""
        return self.layout[-1].start + self.layout[-1].count

    @property
    def word_bits(self) -> int:
        """Bits of a transfer; shorter fields are extended by their sign or by zeros."""
        return max(f.bits + (not f.signed) for f in self.layout)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of all operators, stack by stack: what a result can be a result of."""
        return tuple(op.name for stack in self.stacks.values() for op in stack.operators)

    @property
    def multiplications(self) -> int:
        """Real products of a frame."""
        return sum(op.rows.size for name in self.products for op in self.stacks[name].operators)

    @property
    def nonzero_products(self) -> int:
        """Products of a frame whose coefficient is not zero."""
        return int(sum(np.count_nonzero(op.rows) for name in self.products for op in self.stacks[name].operators))

    @property
    def coefficient_bits(self) -> int:
        """Bits of all coefficients, each stored once."""
        operators = (op for stack in self.stacks.values() for op in stack.operators)
        return sum(op.rows.size * self.formats.bits(f"coefficient.{op.name}") for op in operators)

    @property
    def coefficient_word(self) -> int:
        """Bits of a lane's coefficient: the longest of all operators."""
        return max(self.formats.bits(f"coefficient.{name}") for name in self.kinds)

    @property
    def operand_word(self) -> int:
        """Bits of a lane's operand: the longest of all products."""
        return max(self.formats.bits(f"operand.{name}") for name in self.products)


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
