"""Skins for their C, and frames of them: contacts of every height and width, noise, level codes, corner cases."""

from dataclasses import replace

import numpy as np

from tests.codegen.c.cases import SMALL
from tfra.model.arrays import Ints
from tfra.model.skin.finding import Finding
from tfra.model.skin.skin import Skin


def skin(case: str, rows: int, columns: int, choices: Finding | None = None) -> Skin:
    """An array about the window of a small design."""
    window = SMALL[case]
    return Skin(replace(window.sensor, rows=rows, columns=columns), window, choices or Finding())


SKINS = {
    "smallest": skin("2x2", 2, 2, Finding(gap=4)),
    "narrow": skin("2x2", 3, 17, Finding(most=3, threshold=0.1, gap=1)),
    "learned": skin("learned_4x6", 13, 15, Finding(most=64, threshold=1 / 256, gap=0)),
    "12x20": skin("learned_3x5", 12, 20, Finding(most=8)),
}


def frames(skin: Skin, count: int, seed: int = 1) -> Ints:
    """``count`` frames or some more, ``(n, rows, columns)``."""
    rng = np.random.default_rng(seed)
    half = 1 << (skin.adc.bits - 1)
    shape = (count // 3, skin.sensor.rows, skin.sensor.columns)
    each = (count // 3, 1, 1)
    size = 1 << rng.integers(0, skin.adc.bits, each)
    dense = np.clip(rng.integers(-size, size, shape), -half, half - 1)
    sparse = np.where(rng.random(shape) < rng.uniform(0, 0.2, each), rng.integers(-half, 0, shape), 0)
    level = sparse // (half // 4) * (half // 4)  # peaks are level with each other, and with what they are compared to
    return np.concatenate([directed(skin), dense, level, pressed(rng, shape, half)])


def pressed(rng: np.random.Generator, shape: tuple[int, int, int], half: int) -> Ints:
    """Domes of any height, width and place, and noise."""
    codes = rng.normal(size=shape) * half / 1000
    rows, columns = np.indices(shape[1:])
    for _ in range(10):
        height, width = half * rng.random((2, len(codes), 1, 1)) ** 3
        row, column = rng.random((2, len(codes), 1, 1)) * np.array([shape[1], shape[2]]).reshape(2, 1, 1, 1)
        wide = 1 + 7 * width / half
        codes -= np.maximum(0, height * (1 - ((rows - row) ** 2 + (columns - column) ** 2) / wide**2))
    return np.clip(np.rint(codes), -half, half - 1).astype(np.int64)


def directed(skin: Skin) -> Ints:
    """No contact, traction alone, all pressed, single taxels in corners, more peaks than there may be, the floor."""
    half, least = 1 << (skin.adc.bits - 1), skin.adc.threshold
    shape = (skin.sensor.rows, skin.sensor.columns)
    rows, columns = np.indices(shape)
    corner = (rows % (shape[0] - 1) == 0) & (columns % (shape[1] - 1) == 0)
    grids = ((rows % step == 0) & (columns % step == 0) for step in (2, 3, 4, 5))
    ramp = -(rows * shape[1] + columns) * half // (shape[0] * shape[1])
    return np.stack(
        [np.full(shape, code) for code in (0, half - 1, -half, -least, 1 - least)]
        + [np.where(corner, -half, half - 1), np.where(rows == columns, -half, 0), ramp, -half - ramp]
        + [np.where(grid, -half, 0) for grid in grids]
    ).astype(np.int64)
