"""Errors of every estimator in every scene, of single sensors and pooled."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from bench.accuracy.estimators import estimators, fixed, learned
from bench.accuracy.scenes import NOISES, SCENES, Case, scenes
from tfra.model.arrays import Floats
from tfra.model.cover.layer import frames
from tfra.model.metrics import Contact, errors, turn_deg
from tfra.model.tfra import friction
from tfra.train.heldout import Resultants

MEASURES = {"mu": "mu_abs", "phi_deg": "phi_deg", "force_percent": "force_percent_of_resultant"}
"""Names of the errors here, and in :data:`tfra.model.metrics.ERRORS`."""

PERCENTILES = (50, 95)

FRICTIONS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Of the contacts of the paper."""

PAPER = ("hertz_40x20", "rectangle_40x40")
"""Its sensors."""

BINS = 10
"""Of the true friction, from 0 to 1, in the figure."""

STILL = 0.05
"""Below this friction a direction means little, so fixed and float are compared above it alone."""

Values = dict[str, Floats]
"""By names; each ``(n,)``."""


def observe(case: Case, count: int) -> dict[str, dict[str, Values]]:
    """By scene and estimator: the errors ``MEASURES``, and the friction ``mu_true`` and ``mu_found``."""
    every = estimators(case)
    observed = {}
    for name, codes, force in scenes(case, count):
        truth = Resultants(force)
        observed[name] = {who: compared(truth, estimate(codes)) for who, estimate in every.items()}
    return observed


def compared(truth: Contact, found: Contact) -> Values:
    """The errors and the friction of what is ``found``."""
    every = errors(truth, found)
    own = {"mu_true": truth.mu, "mu_found": found.mu}
    return {measure: every[key] for measure, key in MEASURES.items()} | own


def pooled(observed: Iterable[dict[str, dict[str, Values]]]) -> dict[str, dict[str, Values]]:
    """The frames of all sensors together."""
    every = list(observed)
    return {
        scene: {
            who: {key: np.concatenate([one[scene][who][key] for one in every]) for key in values}
            for who, values in row.items()
        }
        for scene, row in every[0].items()
    }


def percentiles(observed: dict[str, dict[str, Values]]) -> dict[str, Any]:
    """By scene, estimator and measure: ``PERCENTILES``."""
    return {
        scene: {
            who: {measure: np.percentile(values[measure], PERCENTILES).round(5).tolist() for measure in MEASURES}
            for who, values in row.items()
        }
        for scene, row in observed.items()
    }


def curves(observed: dict[str, dict[str, Values]]) -> dict[str, Any]:
    """By noise and estimator: 5th, 50th and 95th percentile of the friction found, for each bin of the true one."""
    return {
        noise: {
            who: [np.percentile(found, (5, 50, 95)).round(5).tolist() for found in _binned(values)]
            for who, values in observed[noise].items()
        }
        for noise in NOISES
    }


def _binned(values: Values) -> list[Floats]:
    """The friction found, for each bin of the true one."""
    which = np.minimum(values["mu_true"] * BINS, BINS - 1).astype(int)
    return [values["mu_found"][which == number] for number in range(BINS)]


def agreement(case: Case, count: int) -> dict[str, float]:
    """99th percentiles of fixed against float, over the frames of ``NOISES``."""
    codes, force = (
        np.concatenate(parts)
        for parts in zip(*(row[1:] for row in scenes(case, count) if row[0] in NOISES), strict=True)
    )
    return differences(learned(case)(codes), fixed(case)(codes), friction(force))


def differences(exact: Contact, other: Contact, mu: Floats) -> dict[str, float]:
    """99th percentiles of the differences in friction and direction, for the true friction ``mu (n,)``."""
    turn = turn_deg(exact.phi_deg, other.phi_deg)
    found = {"mu": np.abs(exact.mu - other.mu), "phi_deg": turn[mu > STILL]}
    return {key: round(float(np.percentile(each, 99)), 6) for key, each in found.items()}


def paper(case: Case) -> dict[str, dict[str, float]]:
    """By noise and friction: the median of what the learned estimator finds for the contacts of the sensor's CONFIG."""
    estimate, sensor, rng = learned(case), case.design.sensor, case.generator("paper")
    stress = {mu: frames(sensor, [replace(c, mu=mu) for c in case.contacts]) for mu in FRICTIONS}
    return {
        noise: {
            f"{mu:g}": round(float(np.median(estimate(SCENES[noise].array.codes(case.design, b, rng)).mu)), 5)
            for mu, b in stress.items()
        }
        for noise in NOISES[:2]
    }
