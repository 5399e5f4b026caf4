"""A design that the learned estimator computes."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from tfra.model.fixed.coefficients import Stack
from tfra.model.fixed.design import Design, signals_of
from tfra.model.fixed.learned.bounds import make_widths
from tfra.model.fixed.learned.operators import OF_FORCES, OPERATORS, make_stacks, names
from tfra.model.fixed.learned.pipeline import FixedLearned
from tfra.model.fixed.learned.resultant import THRESHOLD_FRACTION, threshold_word
from tfra.model.fixed.widths import Widths
from tfra.model.learned.network import Learned, Weights
from tfra.model.tfra import Status

SIGNALS = signals_of(OPERATORS)

_UNUSED = ("direction", "sums")
_SIGNALS_OF_FORCES = (*(f"coefficient.{name}" for name in OF_FORCES), "operand.field", "operand.combine")


@dataclass(frozen=True)
class LearnedDesign(Design):
    """The network of :mod:`tfra.model.learned` with its ``weights``.

    ``threshold``: of the uncertainty over the normal force.  ``taxel_forces``: the core gives forces at the taxels.
    Raises ``ValueError`` that starts with ``estimator.weights:`` for weights of another number of taxels.
    """

    estimator = "learned"
    method = "a network"
    config_keys = ("weights", "taxel_forces")
    signals = SIGNALS
    status_bits = (
        Status.NO_CONTACT, Status.NO_DIRECTION, Status.INPUT_SATURATED, Status.OUTPUT_SATURATED, Status.IMPLAUSIBLE,
    )  # fmt: skip

    weights: Weights = field(kw_only=True)
    threshold: float = field(kw_only=True)
    taxel_forces: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.weights.taxels != self.sensor.taxels:
            reason = f"are for {self.weights.taxels} taxels, the sensor has {self.sensor.taxels}"
            raise ValueError(f"estimator.weights: {reason}")

    @property
    def products(self) -> tuple[str, ...]:
        return tuple(names(self.taxel_forces))

    @property
    def used_signals(self) -> tuple[str, ...]:
        unused = {*_UNUSED, *(() if self.taxel_forces else _SIGNALS_OF_FORCES)}
        return tuple(signal for signal in self.signals if signal not in unused)

    @property
    def result_fields(self) -> tuple[str, ...]:
        header = ("frame", "exponent", "phi", "mu", "mu_x", "mu_y", "resultant", "uncertainty")
        return (*header, "forces", "status") if self.taxel_forces else (*header, "status")

    @property
    def threshold_word(self) -> int:
        """The threshold as the core compares with it."""
        return threshold_word(self.threshold)

    @property
    def uncertainty_threshold(self) -> float:
        """The threshold that this word stands for."""
        return self.threshold_word * 2.0**-THRESHOLD_FRACTION

    @property
    def facts(self) -> dict[str, Any]:
        return {
            "units": list(self.weights.counts),
            "uncertainty_threshold": self.threshold,
            "uncertainty_threshold_word": self.threshold_word,
            "taxel_forces": self.taxel_forces,
        }

    @cached_property
    def stacks(self) -> dict[str, Stack]:
        return make_stacks(self, self.weights, self.taxel_forces)

    @cached_property
    def widths(self) -> Widths:
        return make_widths(self, self.stacks)

    @property
    def model(self) -> FixedLearned:
        return FixedLearned(self, self.threshold_word, self.taxel_forces)

    @property
    def float_model(self) -> Learned:
        """The estimator in double precision; it has forces at the taxels in any case."""
        return Learned(self.sensor, *self.float_settings)

    @property
    def float_settings(self) -> tuple[Weights, float, float]:
        return self.weights, self.threshold, self.adc.threshold * self.adc.lsb
