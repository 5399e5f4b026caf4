"""Expected accuracy of a design before it is built: its agreement with double precision."""

from dataclasses import dataclass

import numpy as np

from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode

DOUBTFUL = 0.95
"""Share of equal frames below which longer words are advised; all format sets and sensors of the README are above."""

NEAR = 0.002
"""Largest difference of frictions that counts as equal where there is no sweep index."""

_WORK = 50_000
"""Taxels of all contacts that are tried, at most 500 contacts."""


@dataclass(frozen=True)
class AccuracyEstimate:
    """``equal``: share of the ``contacts`` that end at float's sweep index, or without a sweep ``near`` its friction.

    ``condition`` is that of C33; None for large arrays, and for an estimator that does not invert it.
    """

    condition: float | None
    contacts: int
    equal: float
    near: float | None = None

    @property
    def doubtful(self) -> bool:
        """Whether the words are too short for such a sensor."""
        return bool(self.contacts) and self.equal < DOUBTFUL

    def __str__(self) -> str:
        known = "" if self.condition is None else f"cond(C33) is {self.condition:,.3g}; "
        end = "at float's sweep index" if self.near is None else f"within {self.near:g} of float's friction"
        return f"{known}{100 * self.equal:.1f} % of {self.contacts} random contacts end {end}"


def accuracy_estimate(design: Design, seed: int = 0) -> AccuracyEstimate:
    """Compare the bit-accurate model with float on the codes of random contacts, at 10 to 95 % of full scale."""
    codes = contact_codes(design, min(500, max(20, _WORK // design.sensor.taxels)), seed)
    exact = design.float_model(codes * design.adc.lsb)
    fixed = decode(design, design.model(codes).words)
    clear = exact.status == 0
    same = exact.sweep_index == fixed.sweep_index if design.sweeps else np.abs(exact.mu - fixed.mu) <= NEAR
    equal = float(same[clear].mean()) if clear.any() else 1.0
    return AccuracyEstimate(design.condition, int(clear.sum()), equal, None if design.sweeps else NEAR)
