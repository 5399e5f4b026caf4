"""A design that TFRA computes."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tfra.model.boussinesq import Operators, operators
from tfra.model.fixed.coefficients import Stack
from tfra.model.fixed.design import Design, signals_of
from tfra.model.fixed.tfra.bounds import make_widths
from tfra.model.fixed.tfra.operators import OPERATORS, PRODUCTS, make_stacks
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.widths import Widths
from tfra.model.tfra import OF_CORES, Tfra

SIGNALS = signals_of(OPERATORS)

MOST_TAXELS = 1024
"""Most taxels for which singular values of a full matrix are computed."""


@dataclass(frozen=True)
class TfraDesign(Design):
    """The estimator of doi:10.1016/j.mechatronics.2023.103070."""

    estimator = "tfra"
    method = "TFRA"
    products = PRODUCTS
    signals = SIGNALS
    status_bits = OF_CORES
    result_fields = (
        "frame", "exponent", "sweep_index", "phi", "mu", "mu_x", "mu_y", "resultant", "forces", "status",
    )  # fmt: skip

    @property
    def exact_operators(self) -> Operators:
        """The operators to quantise, in SI."""
        return operators(self.sensor)

    @cached_property
    def stacks(self) -> dict[str, Stack]:
        return make_stacks(self, self.exact_operators)

    @cached_property
    def widths(self) -> Widths:
        return make_widths(self, self.stacks)

    @property
    def condition(self) -> float | None:
        """That of C33, None for large arrays."""
        return float(np.linalg.cond(self.exact_operators.c33)) if self.sensor.taxels <= MOST_TAXELS else None

    @property
    def model(self) -> FixedTfra:
        return FixedTfra(self)

    @property
    def float_model(self) -> Tfra:
        return Tfra.of(self)

    @property
    def float_settings(self) -> tuple[Hashable, ...]:
        lsb = self.adc.lsb
        return self.search.steps, self.search.tolerance * lsb, self.adc.threshold * lsb
