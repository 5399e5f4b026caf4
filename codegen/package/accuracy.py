"""Accuracy of a core on simulated contacts: against double precision, and against the forces that were simulated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tfra.model.arrays import Floats
from tfra.model.converter import quantise
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.fixed.design import Design
from tfra.model.fixed.words import decode
from tfra.model.metrics import errors

CONTACTS, SEED = 60, 1
"""Contacts of random shape, place, friction and direction, at 5 to 95 % of full scale, without noise."""

_SHOWN = {"phi_deg": "φ / °", "mu_abs": "μ", "force_percent_of_resultant": "F / % of |F|"}


@dataclass(frozen=True)
class _Truth:
    """The simulated contacts: N, 1, degrees."""

    resultant: Floats
    mu: Floats
    phi_deg: Floats


@dataclass(frozen=True)
class Error:
    """Median and 95th percentile of an error ``name`` against ``reference``."""

    reference: str
    name: str
    median: float
    high: float


def accuracy(design: Design) -> tuple[int, list[Error]]:
    """How many contacts have a direction, and the errors of the bit-accurate model on these."""
    rng = np.random.default_rng(SEED)
    loads = random_contacts(design.sensor, CONTACTS, rng)
    stresses = frames(design.sensor, loads)
    scale = rng.uniform(0.05, 0.95, CONTACTS) * design.adc.full_scale / np.abs(stresses).max(axis=(1, 2))
    codes = quantise(design, stresses * scale[:, None, None])
    exact, found = design.float_model(codes * design.adc.lsb), decode(design, design.model(codes).words)
    truth = _Truth(
        np.array([load.force for load in loads]) * scale[:, None],
        np.array([load.mu for load in loads]),
        np.degrees([load.phi for load in loads]),
    )
    clear = exact.status == 0

    def rows() -> Iterator[Error]:
        for reference, values in (("double precision, same codes", exact), ("the simulated contact", truth)):
            by_name = errors(values, found)
            for key, name in _SHOWN.items():
                median, high = np.percentile(by_name[key][clear], (50, 95)) if clear.any() else (0.0, 0.0)
                yield Error(reference, name, float(median), float(high))

    return int(clear.sum()), list(rows())
