"""Designs of the learned estimator with random weights, and frames for them."""

from typing import Any

import numpy as np

from tests.model.learned.random_weights import random_weights
from tfra.model.arrays import Ints
from tfra.model.choices import Adc, Architecture
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.sensor import SensorArray


def learned_design(
    rows: int = 4, columns: int = 5, counts: tuple[int, int] = (3, 2), seed: int = 0, lanes: int = 4, **choices: Any
) -> LearnedDesign:
    """A design of ``counts`` orbits of units; F_z of most frames that press is negative."""
    rng = np.random.default_rng(seed)
    sensor = SensorArray(rows, columns, 4e-3, 3e-3, 2.5e-3)
    weights = random_weights(rng, sensor.taxels, *counts)
    for outputs in (weights.read2, weights.read1, weights.direct):
        outputs *= 0.2
    weights.direct[2] += 0.4
    weights.direct[3] -= 0.2
    given = {"threshold": 0.4, "architecture": Architecture(lanes, 4), "adc": Adc(bits=12)} | choices
    return LearnedDesign(sensor, weights=weights, **given)


def codes_of(design: LearnedDesign, count: int, seed: int) -> Ints:
    """Frames of all sizes: presses, noise, both mixed, full scale, and no contact."""
    rng = np.random.default_rng(seed)
    top = 1 << (design.adc.bits - 1)
    shape = (count, design.sensor.rows, design.sensor.columns)
    size = np.exp2(rng.uniform(0, design.adc.bits - 1, (count, 1, 1)))
    press = rng.integers(0, 2, (count, 1, 1))
    codes = np.rint(size * (rng.normal(size=shape) * rng.choice([0.1, 1.0], (count, 1, 1)) - press))
    codes[::11] = 0
    codes[1::13] = np.where(codes[1::13] < 0, -top, top - 1)
    codes[2::17] = np.abs(codes[2::17])
    return np.clip(codes, -top, top - 1).astype(np.int64)
