"""Angle and Friction against their model, as they work together: a frame at a time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hdl.parallel.designs import Joined, random_words
from tests.hdl.parallel.learned.designs import CASES, few, label
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned.angle import Angle
from tfra.hdl.parallel.learned.friction import Friction
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.friction import angle, friction
from tfra.sim.harness import run


def joined(design: LearnedDesign) -> Joined:
    """A resultant to both blocks, and the modulus from one to the other."""
    wires = [("angle.force", "friction.force"), ("angle.modulus", "friction.modulus")]
    return Joined(wires, angle=Angle(design), friction=Friction(design))


def send(dut, words):
    """Each resultant in the cycle after its token."""
    forces = [{"words": row, "exponent": 0} for row in words.tolist()]
    free = {"angle.force": lambda number, record, cycle: len(record.cycles["friction.scalars_token"]) > number}
    outputs = dict.fromkeys(("angle.angle", "friction.friction", "friction.scalars_token"), len(words))
    return run(dut, {"angle.force": forces}, outputs, leave=free)


def check(design, words):
    dut = joined(design)
    seen = send(dut, words)
    total = Resultant(words, np.zeros(len(words), dtype=np.int64))
    turned = angle(design, total)
    want = friction(design, total, turned)
    for fact, names, found in (
        (turned, ("phi", "still"), seen.values["angle.angle"]),
        (want, ("mu", "mu_x", "mu_y", "overflow"), seen.values["friction.friction"]),
    ):
        for name in names:
            assert [one[name] for one in found] == getattr(fact, name).tolist(), name
    start = np.array(seen.cycles["angle.force"])
    assert set(seen.cycles["friction.friction"] - start) == {dut.friction.latency}
    assert set(seen.cycles["angle.angle"] - start) == {dut.angle.angle_latency}


@few
@given(st.integers(0, 1 << 32), st.sampled_from(CASES))
def test_equals_the_model(seed, design):
    rng = np.random.default_rng(seed)
    words = random_words(rng, design.widths.division, (10, 3))
    words[5:, 2] |= 1 << (design.widths.division - 3)  # friction of a common size
    check(design, words)


@pytest.mark.parametrize("design", CASES, ids=label)
def test_corners(design):
    """No force, no normal force, no tangential force, and friction on both sides of its limit."""
    top = (1 << (design.widths.division - 1)) - 1
    fourth = top // 4
    rows = [[0, 0, 0], [0, 0, -top], [top, -top, 0], [-1, 0, 0], [top, top, 1], [-top - 1, -top - 1, -top - 1]]
    edge = range(4 * fourth - 1, 4 * fourth + 2)
    rows += [[sign * tangential, 0, -fourth] for sign in (1, -1) for tangential in edge]
    check(design, np.clip(np.array(rows), -top - 1, top))


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    words = np.array([[3000, -900, -70000]])
    other = words ^ [[64, 0, 0]]
    with pytest.raises(AssertionError):
        assert send(joined(design), words).values == send(joined(design), other).values
