"""Butterfly against its model under any stalls."""

import numpy as np
import pytest

from tests.marks import STALLS
from tfra.hdl.lib.butterfly import Butterfly
from tfra.model.fixed.butterfly import butterfly
from tfra.sim.harness import run


def _quads(bits, seed, number=40):
    rng = np.random.default_rng(seed)
    low, high = -(1 << (bits - 1)), (1 << (bits - 1)) - 1
    corners = [[low] * 4, [high] * 4, [low, high, low, high], [high, low, low, high], [0] * 4, [1] * 4, [-1] * 4]
    corners += (np.eye(4, dtype=np.int64) * low).tolist()
    return np.concatenate([np.array(corners), rng.integers(low, high, (number, 4), endpoint=True)])


@pytest.mark.parametrize("bits", [6, 29])
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_equals_the_model(bits, stall_in, stall_out):
    quads = _quads(bits, seed=bits)
    seen = run(Butterfly(bits), {"i": quads.tolist()}, {"o": len(quads)}, stall_in=stall_in, stall_out=stall_out)
    assert seen.values["o"] == butterfly(quads).tolist(), f"seed {bits}"


def test_a_quad_a_cycle_and_a_corrupted_word_is_noticed():
    dut, quads = Butterfly(9), _quads(9, 2)
    seen = run(dut, {"i": quads.tolist()}, {"o": len(quads)})
    assert set(np.subtract(seen.cycles["o"], seen.cycles["i"])) == {dut.latency}
    assert set(np.diff(seen.cycles["o"])) == {1}
    wrong = butterfly(quads)
    wrong[5, 2] ^= 1
    assert seen.values["o"] != wrong.tolist()
