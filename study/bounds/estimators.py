"""The bounds of each estimator, a line each."""

from typing import Any

from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.study.bounds.bounds import ErrorBounds
from tfra.study.bounds.learned import LearnedBounds
from tfra.study.bounds.tfra import TfraBounds

_BOUNDS: dict[type[Design], type[Any]] = {TfraDesign: TfraBounds, LearnedDesign: LearnedBounds}


def error_bounds(design: Design) -> ErrorBounds[Any]:
    """The bounds of ``design``."""
    found: ErrorBounds[Any] = _BOUNDS[type(design)](design)
    return found
