"""Weights against its model: corners, designs, stalls, latency."""

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import wiring

from tests.hdl.parallel.designs import label, make
from tfra.hdl.lib.pipeline import delayed
from tfra.hdl.parallel.tfra.weights import Weights
from tfra.model.fixed.butterfly import butterfly
from tfra.model.fixed.tfra.weights import weights
from tfra.sim.harness import PATTERNS, apart, flowing, run

DESIGNS = [make(4, 4), make(5, 7, "wide"), make(2, 2), make(10, 10), make(3, 2, words=1)]
FACTS = [(1, 1), (1, 0), (0, 1), (0, 0), (1, 1)]


def _solutions(design, seed):
    """Frames of folded solutions whose taxels are within a vector's proven bound, corners first."""
    rng = np.random.default_rng(seed)
    limit = (1 << (design.widths.vector - 3)) - 4
    taxels = rng.integers(-limit, limit, (len(FACTS), design.quads, 4), endpoint=True)
    corners = [[limit] * 4, [-limit] * 4, [0] * 4, [1] * 4, [-1] * 4, [limit, -limit, 0, 1], [-1, 2, 1, -2]]
    taxels.reshape(-1, 4)[: len(corners)] = corners[: taxels.size // 4]
    # Not every folded vector is a butterfly of integers: the low bits take any value.
    return butterfly(taxels) + rng.integers(-3, 3, taxels.shape, endpoint=True)


def _inputs(solutions):
    zero = {"exponent": 0, "magnitude": 0, "saturated": 0}
    return {
        "solution": solutions.reshape(-1, 4).tolist(),
        "frame": [zero | {"contact": c, "traction": t} for c, t in FACTS],
    }


def _expected(solutions):
    return weights(solutions, np.array([c and t for c, t in FACTS], dtype=bool)).reshape(-1, 4)


def _run(dut, design, solutions, stall_in=flowing):
    """Facts are there when a frame's quads come, which are as far apart as the updates need."""
    stall_in = apart(stall_in, design.cycles_per_quad)
    return run(dut, _inputs(solutions), {"n": len(FACTS) * design.quads}, stall_in=stall_in, steady=("frame",))


@pytest.mark.parametrize("design", DESIGNS, ids=label)
@pytest.mark.parametrize("stall_in", PATTERNS)
def test_equals_the_model(design, stall_in):
    solutions = _solutions(design, seed=3)
    seen = _run(Weights(design), design, solutions, stall_in)
    assert seen.values["n"] == _expected(solutions).tolist(), "seed 3"


@pytest.mark.parametrize("stall_in", PATTERNS)
def test_payloads_stand_for_as_many_cycles_as_a_quad_has_parts(stall_in):
    design = DESIGNS[-1]
    solutions, inner = _solutions(design, seed=7), Weights(design)

    class Late(wiring.Component):
        """n as it stands in the last of these cycles."""

        def __init__(self):
            super().__init__(inner.signature)

        def elaborate(self, platform):
            m = Module()
            m.submodules.inner = inner
            for name in ("solution", "frame"):
                wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(inner, name))
            valid = delayed(m, inner.n.valid, design.cycles_per_quad - 1, control=True)
            m.d.comb += [self.n.valid.eq(valid), self.n.payload.eq(inner.n.payload)]
            return m

    assert _run(Late(), design, solutions, stall_in).values["n"] == _expected(solutions).tolist()


@pytest.mark.parametrize("design", DESIGNS, ids=label)
def test_latency_and_throughput(design):
    dut, solutions = Weights(design), _solutions(design, seed=4)
    seen = _run(dut, design, solutions)
    into, out = np.array(seen.cycles["solution"]), np.array(seen.cycles["n"])
    assert np.all(out - into == dut.latency)
    assert np.all(np.diff(out) == design.cycles_per_quad)


def test_facts_are_held_until_the_last_quad():
    design = DESIGNS[0]
    seen = _run(Weights(design), design, _solutions(design, 5))
    taken = np.array(seen.cycles["frame"])
    assert np.all(np.diff(taken) == design.quads)


def test_a_corrupted_word_is_noticed():
    design = DESIGNS[0]
    solutions = _solutions(design, seed=6)
    wrong = _expected(solutions)
    wrong[-1, 3] += 1
    seen = _run(Weights(design), design, solutions)
    assert seen.values["n"] != wrong.tolist()
