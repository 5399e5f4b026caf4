"""Designs for cores in C, and their frames: contacts, corners, random codes of every size."""

from dataclasses import replace

import numpy as np

from tests.hdl.parallel.designs import make
from tests.model.fixed.learned.cases import learned_design
from tfra.model.arrays import Ints
from tfra.model.choices import FORMATS, Adc, Formats
from tfra.model.cover.scenes import contact_codes, directed_codes
from tfra.model.fixed.design import Design
from tfra.model.rounding import Rounding

SMALL: dict[str, Design] = {
    "2x2": make(2, 2, Formats("short vectors", 12, 27, 0, 0), bits=6),
    "3x5": make(3, 5, "wide", bits=16, tolerance=0.5),
    "5x4": replace(make(5, 4, steps=33), formats=replace(FORMATS["standard"], rounding=Rounding.HALF_EVEN)),
    "4x4": replace(make(4, 4), formats=replace(FORMATS["standard"], rounding=Rounding.TRUNCATE)),
    "learned_3x5": learned_design(3, 5, formats=FORMATS["wide"], adc=Adc(16)),
    "learned_4x6": learned_design(4, 6, (5, 3), adc=Adc(12), taxel_forces=False),
}


def frames(design: Design, count: int, seed: int = 1) -> Ints:
    """``count`` frames or some more, ``(n, rows, columns)``."""
    rng, half, share = np.random.default_rng(seed), 1 << (design.adc.bits - 1), count // 3
    shape = (share, design.sensor.rows, design.sensor.columns)
    size = 1 << rng.integers(0, design.adc.bits, (share, 1, 1))
    dense = np.clip(rng.integers(-size, size, shape), -half, half - 1)
    sparse = np.where(rng.random(shape) < 0.1, rng.integers(-half, half, shape), 0)
    return np.concatenate([directed_codes(design), contact_codes(design, share, seed), dense, sparse])
