"""The instruments, a line each: what a study knows of the estimators."""

from typing import Any

from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.signals.instrument import Instrument
from tfra.study.signals.learned.instrument import LearnedInstrument
from tfra.study.signals.tfra.instrument import TfraInstrument

_INSTRUMENTS: dict[type[Design], type[Instrument[Any]]] = {TfraDesign: TfraInstrument, LearnedDesign: LearnedInstrument}


def instrument(design: Design) -> Instrument[Any]:
    """The instrument of ``design``."""
    return _INSTRUMENTS[type(design)](design)
