"""The estimators, a line each: what CONFIG, registers and reports know of them.

An estimator is a subclass of :class:`tfra.model.fixed.design.Design`, which states all that differs between them.  Its
cores are a line in :mod:`tfra.hdl.cores`.
"""

from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.tfra.design import TfraDesign

ESTIMATORS: dict[str, type[Design]] = {each.estimator: each for each in (TfraDesign, LearnedDesign)}
"""By their names in CONFIG.  Their order gives their numbers in a core's registers."""

DEFAULT = next(iter(ESTIMATORS))
"""The estimator of a CONFIG that names none."""
