"""The estimators of the comparison: functions of converter codes that find resultants."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import isotonic_regression

from bench.accuracy.scenes import QUIET, SCENES, Case, observed
from tfra.model.arrays import Floats, Ints
from tfra.model.cover.scenes import any_contacts
from tfra.model.fixed.words import decode
from tfra.model.learned.network import Learned
from tfra.model.metrics import Contact
from tfra.model.tfra import Tfra, friction
from tfra.model.two_variable import TwoVariable
from tfra.train.heldout import Resultants

FITTED = 4000
"""Contacts that the map of TFRA's friction is fitted on."""

Estimator = Callable[[Ints], Contact]
"""Function of codes ``(n, rows, columns)``."""

TFRA, TWO_VARIABLE, MAPPED, LEARNED, FIXED = "TFRA", "two-variable", "TFRA, mapped", "learned", "learned, fixed"
NAMES = (TFRA, TWO_VARIABLE, MAPPED, LEARNED, FIXED)


@dataclass(frozen=True, eq=False)
class Mapped:
    """TFRA with its friction corrected by a monotone map, and with the sum of the stress as its normal force.

    ``found (k,)`` rises, and ``true (k,)`` never falls; in between the map is linear.
    """

    tfra: Tfra
    found: Floats
    true: Floats

    @classmethod
    def fitted(cls, tfra: Tfra, stress: Floats, force: Floats) -> "Mapped":
        """The map that is nearest to the friction of ``force (n, 3)`` by least squares, from ``stress`` in Pa."""
        found, where, count = np.unique(tfra(stress).mu, return_inverse=True, return_counts=True)
        mean = np.bincount(where, friction(force)) / count
        return cls(tfra, found, isotonic_regression(mean, weights=count).x)

    def __call__(self, stress: Floats) -> Resultants:
        """Resultants of frames ``(n, rows, columns)`` in Pa."""
        found = self.tfra(stress)
        mu, phi = np.interp(found.mu, self.found, self.true), np.radians(found.phi_deg)
        normal = stress.sum(axis=(1, 2)) * self.tfra.sensor.taxel_area
        tangential = mu * np.abs(normal)
        return Resultants(np.stack([tangential * np.cos(phi), tangential * np.sin(phi), normal], axis=1))


def estimators(case: Case) -> dict[str, Estimator]:
    """Every estimator of one sensor, by ``NAMES``."""
    tfra, two_variable = Tfra.of(case.design), TwoVariable.of(case.design)
    mapped = fit(case, tfra)
    return {
        TFRA: lambda codes: tfra(_stress(case, codes)),
        TWO_VARIABLE: lambda codes: two_variable(_stress(case, codes)),
        MAPPED: lambda codes: mapped(_stress(case, codes)),
        LEARNED: learned(case),
        FIXED: fixed(case),
    }


def learned(case: Case) -> Estimator:
    """The network in floating point."""
    design = case.design
    model = Learned(design.sensor, design.weights, design.threshold, design.adc.threshold * design.adc.lsb)
    return lambda codes: model(_stress(case, codes))


def fixed(case: Case) -> Estimator:
    """The network in the integers of the case's design."""
    return lambda codes: decode(case.design, case.design.model.words(codes))


def fit(case: Case, tfra: Tfra) -> Mapped:
    """The map of one sensor, from contacts of its own at 0.1 % noise."""
    rng = case.generator("map")
    contacts = any_contacts(case.design.sensor, FITTED, rng)
    codes, force = observed(case.design, SCENES[QUIET], contacts, rng)
    return Mapped.fitted(tfra, _stress(case, codes), force)


def _stress(case: Case, codes: Ints) -> Floats:
    """In Pa."""
    return np.multiply(codes, case.design.adc.lsb, dtype=np.float64)
