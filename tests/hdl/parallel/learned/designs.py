"""Designs of the tests of the learned estimator's core, and words for its blocks."""

import random
from typing import Any

import numpy as np
from hypothesis import Phase

from tests.hdl.parallel.cores import mixed
from tests.model.fixed.learned.cases import learned_design
from tfra.model.arrays import Ints
from tfra.model.choices import FORMATS, Adc, Architecture, Formats
from tfra.model.fixed.learned.design import SIGNALS, LearnedDesign

DESIGNS = {
    "standard": learned_design(4, 5),
    "wide": learned_design(3, 5, formats=FORMATS["wide"], adc=Adc(16)),
    "short": learned_design(2, 2, formats=Formats("short", 10, 12, 3, 6)),
    "mixed": learned_design(
        4, 6, formats=Formats("mixed", 12, 20, 9, 2, (("cordic", 24), ("division", 27), ("scalar", 14)))
    ),
}
"""With forces at the taxels."""

NO_SHRINKING = (Phase.explicit, Phase.reuse, Phase.generate)
"""Of hypothesis: a smaller seed tells no more, and each try is a simulation."""

CASES = list(DESIGNS.values())


def label(design: LearnedDesign) -> str:
    """The name of a design's formats."""
    return design.formats.name


def random_design(seed: int, **choices: Any) -> LearnedDesign:
    """Any small array, network, number of lanes and of words a cycle."""
    rng = random.Random(seed)
    rows, columns = rng.randrange(2, 7), rng.randrange(2, 7)
    lanes = rng.randrange(4, 4 * ((rows + 1) // 2) * ((columns + 1) // 2) + 1, 4)
    given = {
        "architecture": Architecture(lanes, rng.choice([1, 2, 4])),
        "adc": Adc(rng.choice([12, 14, 16, 18])),
        "taxel_forces": rng.random() < 0.6,
    }
    return learned_design(rows, columns, (rng.randrange(1, 9), rng.randrange(1, 5)), seed, **given | choices)


def mixed_design(seed: int) -> LearnedDesign:
    """A random design whose signals have word lengths of their own."""
    return mixed(random_design(seed), seed, SIGNALS, 0.5)


def words_of(rng: np.random.Generator, bits: int, shape: tuple[int, ...]) -> Ints:
    """Signed words of ``bits`` and less: every length is as likely, ends of the range among them."""
    top = np.int64(1) << rng.integers(0, bits, shape)
    words = np.where(rng.random(shape) < 0.2, rng.choice([-1, 1], shape) * top, rng.integers(-top, top))
    return np.clip(words, -(1 << (bits - 1)), (1 << (bits - 1)) - 1)
