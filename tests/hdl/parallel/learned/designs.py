"""Designs of the tests of the learned estimator's core."""

import random
from typing import Any

from hypothesis import Phase, settings

from tests.hdl.parallel.designs import mixed
from tests.model.fixed.learned.cases import learned_design
from tfra.model.choices import FORMATS, Adc, Architecture, Formats
from tfra.model.fixed.learned.design import SIGNALS, LearnedDesign

CASES = [
    learned_design(4, 5),
    learned_design(3, 5, formats=FORMATS["wide"], adc=Adc(16)),
    learned_design(2, 2, formats=Formats("short", 10, 12, 3, 6)),
    learned_design(4, 6, formats=Formats("mixed", 12, 20, 9, 2, (("cordic", 24), ("division", 27), ("scalar", 14)))),
]
"""With forces at the taxels."""

few = settings(max_examples=5, phases=(Phase.explicit, Phase.reuse, Phase.generate))
"""Each try is a simulation, and a smaller seed tells no more."""


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
