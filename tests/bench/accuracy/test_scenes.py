"""Scenes are as large as they say, and differ in what they say alone."""

import numpy as np
import pytest

from bench.accuracy.loads import Scene
from bench.accuracy.scenes import LEVELS, NOISES, QUIET, SCENES, Array, observed, scaled, scenes
from tests.bench.accuracy.random_case import SENSOR, random_case
from tfra.model.arrays import Floats
from tfra.model.choices import Adc, Choices
from tfra.model.cover.scenes import any_contacts

CHOICES = Choices(SENSOR, adc=Adc(18, 100e3))
LSB = CHOICES.adc.lsb


def stress(count: int = 300) -> Floats:
    """Frames whose peak is 40 kPa of compression in the first taxel."""
    b = np.random.default_rng(1).uniform(-20e3, 20e3, (count, SENSOR.rows, SENSOR.columns))
    b[:, 0, 0] = -40e3
    return b


def read(array: Array) -> Floats:
    """What the array adds, as a share of the peak."""
    b = stress()
    return (array.codes(CHOICES, b, np.random.default_rng(2)) * LSB - b) / 40e3


def test_noise_and_its_mean() -> None:
    assert np.abs(read(Array(noise=0.0))).max() <= 0.5 * LSB / 40e3
    assert read(Array(noise=1e-2)).std() == pytest.approx(1e-2, rel=0.05)
    assert read(Array(noise=1e-2, frames=16)).std() == pytest.approx(2.5e-3, rel=0.05)


def test_offset_gain_dead_taxel_and_compression() -> None:
    assert read(Array(noise=0.0, offset=-1e-2)) == pytest.approx(-1e-2, abs=1e-5)
    gain = read(Array(noise=0.0, gain=0.1)) * 40e3 / stress()
    assert gain.std() == pytest.approx(0.1, rel=0.05)
    assert gain.std(axis=0).min() > 0.08  # each frame has gains of its own
    still, dead = (Array(noise=0.0, dead=flag).codes(CHOICES, stress(), np.random.default_rng(2)) for flag in (0, 1))
    assert ((still != dead).sum(axis=(1, 2)) == 1).all()
    assert (dead[still != dead] == 0).all()
    pressed = Array(noise=0.0, unsigned=True).codes(CHOICES, stress(), np.random.default_rng(2))
    assert np.array_equal(pressed, np.minimum(still, 0))


def test_scaling_keeps_friction() -> None:
    force = np.array([[1.0, 2.0, -4.0]])
    found = scaled(Scene(stress(1), force), np.array([10e3]))
    assert np.abs(found.stress).max() == pytest.approx(10e3)
    assert found.force == pytest.approx(force / 4)


def test_peaks_are_within_the_levels() -> None:
    case = random_case()
    contacts = any_contacts(SENSOR, 200, np.random.default_rng(3))
    codes, _ = observed(case.design, SCENES["no noise"], contacts, np.random.default_rng(4))
    peak = np.abs(codes).max(axis=(1, 2)) / 2**13
    assert LEVELS[0] - 1e-3 < peak.min() < 0.2
    assert 0.6 < peak.max() < LEVELS[1] + 1e-3


def test_every_scene_has_the_same_contacts() -> None:
    found = {name: (codes, force) for name, codes, force in scenes(random_case(), 12)}
    assert list(found) == list(SCENES)
    assert set(NOISES) < set(SCENES)
    exact, mu = found["no noise"]
    direction = mu / np.linalg.norm(mu, axis=1, keepdims=True)
    for name, (codes, force) in found.items():
        assert codes.shape == exact.shape
        assert name == "no noise" or (codes != exact).any(), name
        turned = np.abs(force / np.linalg.norm(force, axis=1, keepdims=True) - direction).max()
        assert (turned > 1e-9) == (name == "two contacts"), name
    again = {name: codes for name, codes, _ in scenes(random_case(), 12)}
    other = {name: codes for name, codes, _ in scenes(random_case("other"), 12)}
    assert np.array_equal(again[QUIET], found[QUIET][0])
    assert not np.array_equal(other[QUIET], again[QUIET])
