"""Designs to measure with, and their names."""

from typing import Any

import numpy as np

from tfra.model.fixed.design import Design
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.learned.network import Weights
from tfra.model.sensor import SensorArray


def untrained(rows: int, columns: int, counts: tuple[int, int], **choices: Any) -> LearnedDesign:
    """A design with random weights; the sum of the stress is in F_z, so that most frames press."""
    (c1, c2), rng, m = counts, np.random.default_rng(rows), rows * columns
    weights = Weights(*(rng.normal(size=shape) / m for shape in ((c1, m), (4, c2, c1), (4, c2), (4, c1), (4, m))))
    weights.direct[2] += 0.25
    sensor, name = SensorArray(rows, columns, 2.5e-3, 3e-3, 2.5e-3), f"learned_{rows}x{columns}"
    return LearnedDesign(sensor, name, weights=weights, threshold=0.25, **choices)


def core(of: Design) -> str:
    """The core in a few words."""
    if of.architecture.kind == "serial":
        return "serial"
    forces = "" if "forces" in of.result_fields else ", no forces at the taxels"
    words = of.architecture.vector_words
    return f"{of.architecture.mac_lanes} lanes, {words} word{'s' * (words > 1)} a cycle{forces}"
