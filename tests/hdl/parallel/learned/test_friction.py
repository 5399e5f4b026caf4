"""Angle and Friction against their model, as they work together: a frame at a time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.parallel.designs import Joined
from tests.hdl.parallel.learned.designs import CASES, DESIGNS, NO_SHRINKING, label, words_of
from tests.model.fixed.learned.cases import learned_design
from tfra.hdl.parallel.learned.angle import Angle
from tfra.hdl.parallel.learned.friction import Friction
from tfra.model.fixed.gain import Resultant
from tfra.model.fixed.learned.design import LearnedDesign
from tfra.model.fixed.learned.friction import angle, friction
from tfra.sim.harness import run


def joined(design: LearnedDesign) -> Joined:
    """A resultant to both blocks, and the modulus from one to the other."""
    ports = {
        "force": ("angle.force", "friction.force"),
        "turned": "angle.angle",
        "found": "friction.friction",
        "token": "friction.scalars_token",
    }
    blocks = {"angle": Angle(design), "friction": Friction(design)}
    return Joined(blocks, ports, [("angle.modulus", "friction.modulus")])


def send(design, words):
    """Each resultant in the cycle after its token."""
    forces = [{"words": row, "exponent": 0} for row in words.tolist()]
    free = {"force": lambda number, record, cycle: len(record.cycles["token"]) > number}
    count = len(words)
    return run(joined(design), {"force": forces}, {"turned": count, "found": count, "token": count}, leave=free)


def check(design, words):
    seen = send(design, words)
    total = Resultant(words, np.zeros(len(words), dtype=np.int64))
    turned = angle(design, total)
    want = friction(design, total, turned)
    assert [one["phi"] for one in seen.values["turned"]] == turned.phi.tolist()
    assert [bool(one["still"]) for one in seen.values["turned"]] == turned.still.tolist()
    for name in ("mu", "mu_x", "mu_y"):
        assert [one[name] for one in seen.values["found"]] == getattr(want, name).tolist(), name
    assert [bool(one["overflow"]) for one in seen.values["found"]] == want.overflow.tolist()
    return seen


@settings(max_examples=5, deadline=None, phases=NO_SHRINKING)
@given(st.integers(0, 1 << 32), st.sampled_from(sorted(DESIGNS)))
def test_equals_the_model(seed, name):
    design = DESIGNS[name]
    rng = np.random.default_rng(seed)
    words = words_of(rng, design.widths.division, (10, 3))
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


def test_latency_is_as_stated():
    design = learned_design(2, 2)
    blocks, words = joined(design).blocks, np.array([[3000, -900, -70000], [5, 5, 5]])
    seen = check(design, words)
    start = np.array(seen.cycles["force"])
    assert (np.array(seen.cycles["found"]) - start).tolist() == [blocks["friction"].latency] * 2
    assert (np.array(seen.cycles["turned"]) - start).tolist() == [blocks["angle"].angle_latency] * 2


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2)
    words = np.array([[3000, -900, -70000]])
    other = words ^ [[64, 0, 0]]
    with pytest.raises(AssertionError):
        assert send(design, words).values == send(design, other).values
