"""Random designs of TFRA for whole cores."""

import random

from tests.hdl.parallel.cores import mixed
from tests.hdl.parallel.designs import make
from tfra.model.fixed.tfra.design import SIGNALS, TfraDesign


def random_design(seed: int) -> TfraDesign:
    """Any small array with any number of lanes, any number of words a cycle, and any contact threshold."""
    rng = random.Random(seed)
    rows, columns, steps = rng.randrange(2, 8), rng.randrange(2, 8), rng.choice([4, 12, 33])
    lanes = rng.choice(range(4, 4 * ((rows + 1) // 2) * ((columns + 1) // 2) + 1, 4))
    words = rng.choice([1, 2, 4])
    threshold = rng.choice([None, 0, rng.randrange(2000)])
    return make(rows, columns, steps=steps, lanes=lanes, words=words, threshold=threshold)


def mixed_design(seed: int) -> TfraDesign:
    """A random design whose signals have word lengths of their own."""
    return mixed(random_design(seed), seed, SIGNALS, 0.6)
