"""The stages of an estimator in float64, one after the other."""

from collections.abc import Callable, Sequence
from typing import Any

from tfra.model.arrays import Ints
from tfra.study.signals.measures import Values


class Stages:
    """``steps`` take the signals of those before them, and the model's decisions; each returns signals by name."""

    steps: Sequence[Callable[[Values, Any], Values]]

    def from_codes(self, codes: Ints, decided: Any) -> Values:
        """Every signal of ``codes (n, m)``, each stage fed with the reference of those before it."""
        values: Values = {"codes": codes}
        for step in self.steps:
            values |= step(values, decided)
        return values

    def from_inputs(self, values: Values, decided: Any) -> Values:
        """Every signal, each stage fed with ``values``: the model's own signals, and ``codes``."""
        return {name: value for step in self.steps for name, value in step(values, decided).items()}
