"""Expected accuracy of a design before it is built: condition number of its sensor, agreement with float's sweep
index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfra.model.boussinesq import operators
from tfra.model.cover.scenes import contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.tfra import Tfra

MOST_TAXELS = 1024
"""Most taxels for which singular values of a full matrix are computed."""

DOUBTFUL = 0.95
"""Share of equal indices below which longer words are advised; all format sets and sensors of the README are above."""

_WORK = 50_000
"""Taxels of all contacts that are tried, at most 500 contacts."""


@dataclass(frozen=True)
class Outlook:
    """``condition`` of C33, None for large arrays; share of ``equal`` indices among the ``contacts`` that are swept."""

    condition: float | None
    contacts: int
    equal: float

    @property
    def doubtful(self) -> bool:
        """Whether the words are too short for such a sensor."""
        return bool(self.contacts) and self.equal < DOUBTFUL

    def __str__(self) -> str:
        known = "" if self.condition is None else f"cond(C33) is {self.condition:,.3g}; "
        return f"{known}{100 * self.equal:.1f} % of {self.contacts} random contacts end at float's sweep index"


def outlook(design: Design, seed: int = 0) -> Outlook:
    """Measure random contacts at 5 to 95 % of full scale, in the bit-accurate model and in float on the same codes."""
    sensor = design.sensor
    codes = contact_codes(design, min(500, max(20, _WORK // sensor.taxels)), seed)
    exact, found = Tfra.of(design)(codes * design.adc.lsb), decode(design, design.model(codes).words)
    swept = exact.status == 0
    same = exact.sweep_index[swept] == found.sweep_index[swept]
    condition = float(np.linalg.cond(operators(sensor).c33)) if sensor.taxels <= MOST_TAXELS else None
    return Outlook(condition, int(swept.sum()), float(same.mean()) if len(same) else 1.0)
