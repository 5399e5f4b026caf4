"""Lines: every word of frames with those above and below it, however the words come."""

import numpy as np
import pytest

from tfra.hdl.skin.lines import Lines
from tfra.sim.harness import PATTERNS, flowing, run


@pytest.mark.parametrize("shape", [(2, 2), (3, 5), (5, 2)])
@pytest.mark.parametrize("stalls", PATTERNS)
def test_words_come_with_their_neighbours(shape, stalls):
    frames = np.random.default_rng(3).integers(0, 256, (4, *shape))
    seen = run(Lines(8, *shape), {"i": frames.ravel().tolist()}, {"o": frames.size}, stall_in=stalls, seed=1)
    padded = np.pad(frames, ((0, 0), (1, 1), (0, 0)))
    for number, got in enumerate(seen.values["o"]):
        frame, row, column = np.unravel_index(number, frames.shape)
        above, centre, below = padded[frame, row : row + 3, column].tolist()
        want = {"above": above, "centre": centre, "below": below}
        assert got == want | {"start": column == 0, "end": column == shape[1] - 1}


@pytest.mark.parametrize("shape", [(4, 6), (2, 2), (9, 3)])
def test_a_word_a_cycle_and_the_last_row_leaves_by_itself(shape):
    frames = np.zeros((2, *shape), dtype=np.int64)
    seen = run(Lines(8, *shape), {"i": frames.ravel().tolist()}, {"o": frames.size}, stall_in=flowing)
    assert (np.diff(seen.cycles["i"]) == 1).all()
    assert seen.cycles["o"][-1] == seen.cycles["i"][-1] + shape[1] + Lines.latency
