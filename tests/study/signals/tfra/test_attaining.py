"""Attaining frames: recomputed from their codes alone, below what no frame can have, and the same in the gateware."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from tests.model.cases import make_design
from tests.study.signals.tfra.attaining import ENOUGH, attaining, replay
from tests.study.signals.tfra.ceilings import ceilings
from tfra.hdl.parallel.matvec import unit
from tfra.model.boussinesq import operators
from tfra.model.choices import Architecture, Search
from tfra.model.fixed.butterfly import butterfly, to_quads
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

COARSE = SensorArray(4, 4, 8e-3, 8e-3, 2e-3)
SENSORS_HERE = {"3×3": SensorArray(3, 3, 4e-3, 2e-3, 3e-3), "4×4": COARSE, "5×4": SensorArray(5, 4, 4e-3, 2e-3, 3e-3)}
DESIGNS = {name: make_design(sensor, steps=10) for name, sensor in SENSORS_HERE.items()}
TOLERANCE = 2e-3
"""What rounding may add to a ceiling."""


@pytest.mark.parametrize("name", DESIGNS)
def test_frames_come_near_the_bounds_and_never_over_them(name):
    design = DESIGNS[name]
    extremes = attaining(design)
    limits = ceilings(design)
    reached = {signal for signal in extremes.words if extremes.share(signal) >= ENOUGH}
    exact = {signal for signal in extremes.words if signal.endswith(".accumulator")}
    assert reached >= exact | {"stress", "b", "c33_inv", "n", "sums_b", "moment", "magnitude", "mu_ind"}
    for signal, word in extremes.words.items():
        ceiling = limits.get(signal, word.bound)
        assert extremes.best[signal].magnitude <= word.bound
        assert ceiling <= word.bound * (1 + 1e-9)
        assert extremes.best[signal].magnitude <= ceiling * (1 + TOLERANCE)
        # Where a frame could have more than half, the one that was found is not far from it.
        near = {"sums_n", "sums", "c33", "unscaled", "force", "alpha", "beta"}
        assert signal in reached | near or ceiling < ENOUGH * word.bound


def test_ceilings_are_not_far_from_what_all_extreme_frames_have():
    """Every sign of every taxel of 2×3, unquantised: g, d1, d2 and d0 are the largest at such a frame."""
    sensor = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
    design = make_design(sensor)
    ops, h2 = operators(sensor), sensor.thickness**2
    b = np.array(list(product([-1.0, 0.0, 1.0], repeat=6))) * (8192 << 9)
    n = np.maximum(-(b @ ops.c33_inv.T) / h2, 0)
    exact = {"c33": n @ ops.c33.T * h2, "c31": n @ ops.c31.T * h2, "c32": n @ ops.c32.T * h2}
    exact["d0"] = b + exact["c33"]
    limits = ceilings(design)
    for signal, vectors in exact.items():
        largest = np.abs(butterfly(to_quads(design, vectors))).max()
        assert 0.5 * limits[signal] < largest <= limits[signal] * (1 + 1e-9), signal


SMALL = TfraDesign(SensorArray(2, 2, 8e-3, 8e-3, 2e-3), search=Search(5), architecture=Architecture(4))


def frames_of(design, count):
    """Frames that reach half of a bound, each once."""
    found = attaining(design)
    frames = [best.frame for signal, best in found.best.items() if found.share(signal) >= ENOUGH]
    return np.unique(np.stack(frames), axis=0)[:count]


@pytest.mark.long
def test_every_stage_of_the_gateware_gives_the_models_words(builds):
    for design in (SMALL, replace(SMALL, sensor=COARSE)):
        assert replay(design, frames_of(design, 5), "icarus", builds) == []


@pytest.mark.long
def test_a_wrong_coefficient_is_noticed(monkeypatch):
    def corrupted(design):
        images = original(design).copy()
        images[0, 0] ^= 1 << 12
        return images

    original = unit.lane_images
    monkeypatch.setattr(unit, "lane_images", corrupted)
    assert replay(SMALL, frames_of(SMALL, 2), "amaranth")
