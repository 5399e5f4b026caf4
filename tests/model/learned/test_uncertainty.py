"""What docs/learned.md says of the uncertainty, on the trained arrays of the examples and frames of the exact layer."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import spearmanr

from bench.accuracy.scenes import Case, cases
from tfra.model.arrays import Bools, Floats
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status

COUNT = 300

SHARES = {(1, 2): (0.02, 0.35), (2, 3): (0.5, 0.97), (3, 4): (0.97, 1.0)}
"""Distances in pitches, and the least and the largest share of pairs that are noticed."""


def frames(sensor: SensorArray, center: Floats, half: Floats, force: Floats) -> Floats:
    contacts = Contacts(np.array(["hertz"] * len(center)), center, half, force)
    x, y = np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
    return ElasticLayer.under(sensor).base_stress(contacts, x, y)


def forces(rng: np.random.Generator, least: float = 1.0) -> Floats:
    mu, phi, normal = rng.uniform(0, 1, COUNT), rng.uniform(0, 2 * np.pi, COUNT), rng.uniform(least, 1, COUNT)
    return np.stack([mu * normal * np.cos(phi), mu * normal * np.sin(phi), -normal], axis=1)


@pytest.mark.parametrize("case", [case for case in cases() if "array" not in case.name], ids=lambda case: case.name)
def test_pairs_are_noticed_by_their_distance(case: Case) -> None:
    rng, sensor = np.random.default_rng(5), case.design.sensor
    pitch = np.array([sensor.pitch_x, sensor.pitch_y])
    middle = np.array([(sensor.columns - 1) * sensor.pitch_x, (sensor.rows - 1) * sensor.pitch_y]) / 2
    for (near, far), (least, most) in SHARES.items():
        angle, distance = rng.uniform(0, 2 * np.pi, COUNT), rng.uniform(near, far, COUNT) * pitch.max()
        aside = np.stack([np.cos(angle), np.sin(angle)], axis=1) * distance[:, None] / 2
        half = rng.uniform(0.5, 1.2, (COUNT, 1)) * pitch.min() * np.ones((1, 2))
        inside = (np.abs(aside) < middle + pitch / 2 - 1.01 * half).all(axis=1)
        first, second = forces(rng), forces(rng, 0.2)
        one, other = ((middle + aside)[inside], first[inside]), ((middle - aside)[inside], second[inside])
        stress = sum(frames(sensor, place, half[inside], force) for place, force in (one, other))
        assert least <= noticed(case.design.float_model, stress).mean() <= most


def noticed(model: Callable[[Floats], object], stress: Floats) -> Bools:
    return np.asarray(model(stress).status & Status.IMPLAUSIBLE != 0)


@pytest.mark.parametrize("case", [case for case in cases() if "array" not in case.name], ids=lambda case: case.name)
def test_it_tells_little_of_clean_frames(case: Case) -> None:
    rng, sensor = np.random.default_rng(6), case.design.sensor
    pitch = np.array([sensor.pitch_x, sensor.pitch_y])
    middle = np.array([(sensor.columns - 1) * sensor.pitch_x, (sensor.rows - 1) * sensor.pitch_y]) / 2
    half = rng.uniform(0.5, 2, (COUNT, 2)) * pitch
    center, force = middle + rng.uniform(-1, 1, (COUNT, 2)) * (middle + pitch / 2 - 1.01 * half), forces(rng)
    result = case.design.float_model(frames(sensor, center, half, force))
    error = np.linalg.norm(result.resultant - force, axis=1)
    assert 0.1 < spearmanr(result.uncertainty, error)[0] < 0.45
    assert (result.status & Status.IMPLAUSIBLE != 0).mean() < 0.03
