"""Forces against its model: rounding, the walk over odd and even arrays, stalls, latency."""

import numpy as np
import pytest

from tests.hdl.parallel.designs import label, make
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.forces import Forces
from tfra.model.choices import Formats
from tfra.model.fixed.butterfly import butterfly, to_taxels
from tfra.model.fixed.numbers import round_shift
from tfra.model.fixed.widths import force_drop
from tfra.sim.harness import apart, bursts, flowing, random_stalls, run

DESIGNS = [
    make(4, 4),
    make(5, 7, "wide"),
    make(4, 6, Formats("no drop", 16, 18, 4, 6)),
    make(7, 4),
    make(2, 2),
    make(3, 2),
    make(2, 3, "wide"),
    make(2, 2, words=1),
    make(5, 4, words=1),
    make(4, 3, words=2),
]
WALKS = [(rows, columns) for rows in (2, 3, 6, 16) for columns in (2, 3, 5, 16)]
FRAMES = 3


def _folded(design, seed, frames=FRAMES):
    """Folded planes ``(3 frames, Q, 4)`` whose taxels are within a vector's proven bound, corners first."""
    rng = np.random.default_rng(seed)
    limit = (1 << (design.widths.vector - 3)) - (1 << force_drop(design)) - 4
    taxels = rng.integers(-limit, limit, (3 * frames, design.quads, 4), endpoint=True)
    corners = [[limit] * 4, [-limit] * 4, [0] * 4, [1] * 4, [-1] * 4, [limit, -limit, 0, 1]]
    taxels.reshape(-1, 4)[: len(corners)] = corners[: taxels.size // 4]
    # Ties and their neighbours, and folded vectors that no integer taxels have.
    return butterfly(taxels) + rng.integers(-2, 2, taxels.shape, endpoint=True)


def _expected(design, folded):
    return to_taxels(design, round_shift(butterfly(folded), force_drop(design))).ravel()


def _run(dut, design, folded, number, stall_in=flowing, stall_out=flowing):
    """Three planes for every token, their quads as far apart as the memory needs."""

    def leave(quad, record, cycle):
        return len(record.cycles["plane_token"]) > quad // (3 * design.quads)

    outputs = {"taxel": number, "plane_token": len(folded) // 3}
    how = {"stall_in": apart(stall_in, design.cycles_per_quad), "stall_out": stall_out, "leave": {"folded": leave}}
    return run(dut, {"folded": folded.reshape(-1, 4).tolist()}, outputs, **how)


@pytest.mark.parametrize("design", DESIGNS, ids=label)
@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_equals_the_model(design, stall_in, stall_out):
    folded = _folded(design, seed=1)
    expected = _expected(design, folded)
    seen = _run(Forces(design), design, folded, len(expected), stall_in=stall_in, stall_out=stall_out)
    assert seen.values["taxel"] == expected.tolist(), "seed 1"


@pytest.mark.parametrize("size", WALKS, ids=str)
def test_walks_over_any_array(size):
    design = make(*size)
    folded = _folded(design, seed=2, frames=1)
    expected = _expected(design, folded)
    seen = _run(Forces(design), design, folded, len(expected), stall_in=bursts)
    assert seen.values["taxel"] == expected.tolist(), "seed 2"


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_latency_and_throughput(design):
    """Quads come as fast as the updates give them."""
    dut, folded, plane = Forces(design), _folded(design, seed=3), design.sensor.taxels
    seen = _run(dut, design, folded, folded.shape[0] * plane)
    into, out = seen.cycles["folded"], seen.cycles["taxel"]
    assert out[0] - into[design.quads - 1] == dut.latency
    assert out[plane] - out[0] == max(plane, design.quads * design.cycles_per_quad)
    assert np.all(np.diff(np.reshape(out, (-1, plane))) == 1)


def test_latency_of_a_plane_that_comes_late():
    design = DESIGNS[0]
    dut, q = Forces(design), design.quads
    rests = ([False] * q + [True] * 40) * 9 + [True]
    seen = _run(dut, design, _folded(design, 4), 9 * 16, stall_in=lambda rng: iter(rests))
    starts = np.array(seen.cycles["taxel"])[::16]
    assert np.all(starts - np.array(seen.cycles["folded"])[q - 1 :: q] == dut.latency)


def test_a_corrupted_word_is_noticed():
    design = DESIGNS[0]
    folded = _folded(design, seed=5)
    wrong = _expected(design, folded)
    wrong[-1] -= 1
    seen = _run(Forces(design), design, folded, len(wrong), stall_in=random_stalls)
    assert seen.values["taxel"] != wrong.tolist()
