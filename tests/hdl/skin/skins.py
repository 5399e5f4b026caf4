"""Skins for the tests, and frames for them."""

from dataclasses import replace

import numpy as np

from tests.model.fixed.learned.cases import learned_design
from tfra.model.arrays import Ints
from tfra.model.choices import Adc, Architecture
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding
from tfra.model.skin.skin import Skin


def small_window(rows: int = 2, columns: int = 3, threshold: int = 4) -> TfraDesign:
    """A parallel core of few cycles."""
    sensor = SensorArray(rows, columns, 4e-3, 3e-3, 2.5e-3)
    adc = Adc(bits=12, contact_threshold=threshold)
    return TfraDesign(sensor, adc=adc, architecture=Architecture(4, 4))


def skin_of(rows: int, columns: int, window: Design | None = None, **choices: float) -> Skin:
    """A skin of so many taxels."""
    window = window or small_window()
    return Skin(replace(window.sensor, rows=rows, columns=columns), window, Finding(**choices))


def bumps(rng: np.random.Generator, shape: tuple[int, int], count: int, radius: float = 3.0) -> Ints:
    """A frame of round contacts at random places, anywhere on the array."""
    row, column = np.indices(shape)
    frame = np.zeros(shape)
    for _ in range(count):
        y, x = rng.uniform(-0.5, np.array(shape) - 0.5)
        size = rng.uniform(0.2, 1.8)
        frame -= size * 1000 * np.clip(1 - ((row - y) ** 2 + (column - x) ** 2) / radius**2, 0, None)
    return _codes(frame)


def grid(shape: tuple[int, int], counts: tuple[int, int], radius: float) -> Ints:
    """A frame of equal round contacts far from each other."""
    row, column = np.indices(shape)
    frame = np.zeros(shape)
    for y in (np.arange(counts[0]) + 0.5) * shape[0] / counts[0]:
        for x in (np.arange(counts[1]) + 0.5) * shape[1] / counts[1]:
            frame -= 1500 * np.clip(1.2 - ((row - y) ** 2 + (column - x) ** 2) / radius**2, 0, 1)
    return _codes(frame)


def frames_of(skin: Skin, seed: int, count: int) -> Ints:
    """Frames of all kinds in turn: contacts, noise, none, few taxels, edges, steps, all pressed, traction."""
    rng, shape = np.random.default_rng(seed), (skin.sensor.rows, skin.sensor.columns)
    top = 1 << (skin.adc.bits - 1)
    edges = np.zeros(shape, dtype=np.int64)
    edges[[0, 0, -1, -1], [0, -1, 0, -1]] = rng.integers(-top, 0, 4)
    edges[shape[0] // 2, [0, -1]] = -top // 2
    kinds = [
        bumps(rng, shape, 4),
        rng.integers(-top, top, shape),
        np.zeros(shape, dtype=np.int64),
        np.where(rng.random(shape) < 0.05, rng.integers(-top, top, shape), 0),
        edges,
        bumps(rng, shape, 9, 2.0) + rng.integers(-20, 20, shape),
        np.full(shape, -top),
        -300 * rng.integers(0, 4, shape),
        np.full(shape, top - 1),
        -200 * (np.indices(shape).sum(axis=0) % 5 > 1),
    ]
    return np.stack([_codes(kinds[(seed + k) % len(kinds)], top) for k in range(count)])


def _codes(frame: np.ndarray, top: int = 2048) -> Ints:
    return np.clip(np.rint(frame), -top, top - 1).astype(np.int64)


def learned_window(rows: int = 10, columns: int = 10) -> Design:
    """A learned estimator whose core loads its coefficients."""
    return learned_design(rows, columns, counts=(4, 3), lanes=4)
