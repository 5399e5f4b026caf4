"""What an estimator supplies for a study of its inside: signals by stage, their words and their float64 values."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol, TypeGuard, TypeVar

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.signals.tfra.instrument import TfraInstrument
from tfra.study.signals.words import Observed, Word

Trace = TypeVar("Trace")
"""All results of a bit-accurate model for some frames."""


class Instrument(Protocol[Trace]):
    """The signals inside the bit-accurate model of one design."""

    @property
    def catalogue(self) -> Mapping[str, Word]:
        """The word of every signal whose range is measured, in the order of the stages."""

    def stage(self, signal: str) -> str:
        """The stage of ``signal``."""

    def traces(self, codes: Ints) -> Iterable[Trace]:
        """Traces of converter codes ``(n, rows, columns)``, some frames at a time."""

    def observe(self, trace: Trace) -> Mapping[str, Observed]:
        """Every signal of ``catalogue``."""

    def comparable(self, trace: Trace) -> Bools:
        """Whether the signals of each frame, ``(n,)``, can be compared with float64."""

    def compare(self, trace: Trace, frames: Bools) -> Mapping[tuple[str, str], tuple[Floats, Floats]]:
        """By signal and reference: float64 values of some ``frames``, and errors of the words, both in LSB.

        The reference ``codes`` is float64 from the converter codes on, ``inputs`` float64 in the signal's stage alone.
        Both take over the model's decisions.
        """

    def flips(self, trace: Trace) -> Mapping[str, Ints]:
        """By decision: how many frames agree in those before it, and in how many of them float decides otherwise."""


_INSTRUMENTS: Mapping[type[Design], Callable[[Any], Instrument[Any]]] = {TfraDesign: TfraInstrument}
"""By the designs of each estimator that can be studied."""


def can_be_studied(design: Design) -> TypeGuard[TfraDesign]:
    """Whether there is an instrument for the estimator of ``design``."""
    return type(design) in _INSTRUMENTS


def instrument(design: Design) -> Instrument[Any]:
    """The instrument for ``design``."""
    return _INSTRUMENTS[type(design)](design)
