"""Field against its model: any vectors within the bounds, friction beyond its limit, frames ahead of their contact."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.learned.designs import CASES, few, label
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned.field import Field
from tfra.hdl.parallel.learned.plan import FRAMES
from tfra.model.fixed.butterfly import distinct, to_quads
from tfra.model.fixed.learned.field import field
from tfra.model.fixed.learned.friction import Friction
from tfra.model.fixed.widths import scalar_fraction
from tfra.sim.harness import PATTERNS, flowing, run

NUMBER = 5
OPERATORS = ("inverse", "shear_x", "shear_y")


def draw(design, seed):
    """Vectors ``(3, n, Q, 4)`` whose sums stay within the bound of p, and scalars ``(2, n)`` of any size."""
    rng = np.random.default_rng(seed)
    vectors = random_words(rng, design.widths.force - 7, (3, NUMBER, design.quads, 4))
    vectors >>= rng.integers(0, design.widths.force - 7, (3, NUMBER, 1, 1))
    scalars = random_words(rng, design.formats.bits("scalar"), (2, NUMBER))
    scalars[:, :2] = [[2 << scalar_fraction(design)] * 2, [-2 << scalar_fraction(design), 0]]
    return vectors, scalars


def expected(design, vectors, scalars):
    zero = np.zeros(NUMBER, dtype=np.int64)
    found = Friction(zero, scalars[0], scalars[1], zero > 0)
    return to_quads(design, field(design, vectors[0], (vectors[1], vectors[2]), found))


def first_of(design, quads):
    """Words of quads that are the first to hold their taxel: vectors here have odd parts on the middle line, too."""
    return np.reshape(quads, (NUMBER, design.quads, 4))[:, distinct(design)].tolist()


def send(design, vectors, scalars, stall_in=flowing, seed=0):
    """Products of no more than ``FRAMES`` frames before the p of the first of them."""
    sent = [
        {"words": quad, "kind": 1 << design.kinds.index(name)}
        for frame in range(NUMBER)
        for number, name in enumerate(OPERATORS)
        for quad in vectors[number, frame].tolist()
    ]
    total = {"words": [0, 0, 0], "exponent": 0}
    facts = [{"total": total, "mu_x": x, "mu_y": y} for x, y in scalars.T.tolist()]
    q = design.quads

    def place(number, record, cycle):
        return number // (3 * q) < len(record.values["p"]) // q + FRAMES

    return run(
        Field(design),
        {"result": sent, "contact": facts, "share_token": [0] * NUMBER},
        {"p": NUMBER * q},
        stall_in=stall_in,
        leave={"result": place},
        seed=seed,
    )


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES), st.sampled_from(PATTERNS))
def test_equals_the_model(seed, design, stall):
    vectors, scalars = draw(design, seed)
    seen = send(design, vectors, scalars, stall, seed)
    assert first_of(design, seen.values["p"]) == first_of(design, expected(design, vectors, scalars))


@pytest.mark.parametrize("design", CASES, ids=label)
def test_latency_and_interval_are_as_stated(design):
    """All is there but the last vector: the first frame begins as soon as that is, the others in turn."""
    vectors, scalars = draw(design, 1)
    seen, block, q = send(design, vectors, scalars), Field(design), design.quads
    block._MustUse__silence = True  # figures alone are wanted
    ends = np.array(seen.cycles["p"])[q - 1 :: q]
    assert ends[0] == seen.cycles["result"][3 * q - 1] + block.vectors_latency + block.latency
    busy = np.diff(ends[:FRAMES])
    arrived = np.diff(np.array(seen.cycles["result"])[3 * q - 1 :: 3 * q])[: FRAMES - 1]
    assert (busy == np.maximum(block.interval, arrived)).all()


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    vectors, scalars = draw(design, 2)
    seen = send(design, vectors, scalars)
    vectors[0] += 4
    assert first_of(design, seen.values["p"]) != first_of(design, expected(design, vectors, scalars))
