"""Dependent against its model: real frames, random words, every limit, stalls and constant time."""

from itertools import product

import numpy as np
import pytest

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.facts import (
    DESIGNS,
    random_codes,
    random_direction,
    random_frames,
    real_sums,
    regular_frames,
    transfers,
)
from tests.marks import STALLS, long
from tfra.hdl.parallel.tfra.dependent import Dependent
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.tfra.dependent import dependent, gather_sums
from tfra.sim.harness import run


def split(design, exact, rng):
    """Sum quads whose A_pq are ``exact (n, 3, 3)``; the words they do not use are noise."""
    bits = design.widths.vector
    half = 1 << (bits - 1)
    b, n = random_words(rng, bits, (len(exact), 1, 4)), random_words(rng, bits, (len(exact), 3, 4))
    for row, parity, quad, place in ((0, OX, 0, OX), (1, OY, 0, OY), (2, EE, 2, EE)):
        total = exact[:, row, 0]
        b[:, 0, parity] = rng.integers(np.maximum(-half, total - half + 1), np.minimum(half, total + half + 1))
        n[:, quad, place] = total - b[:, 0, parity]
    for (p, q), (quad, place) in {
        (0, 1): (0, EE),
        (0, 2): (0, OO),
        (1, 1): (1, OO),
        (1, 2): (1, EE),
        (2, 1): (1, OX),
        (2, 2): (1, OY),
    }.items():
        n[:, quad, place] = exact[:, p, q]
    assert np.array_equal(gather_sums(b, n), exact)
    return b, n


def send(dut, frame, direction, b, n, **stalls):
    quads = np.concatenate([b, n], axis=1).reshape(-1, 4).tolist()
    facts = {"sums": quads, "direction": transfers(direction), "frame": transfers(frame)}
    return run(dut, facts, {"affine": len(b)}, **stalls)


def check(design, frame, direction, b, n, **stalls):
    """Words, and the latency when nothing stalls; returns the model's facts."""
    dut, model = Dependent(design), dependent(design, gather_sums(b, n), direction, frame.regular)
    seen = send(dut, frame, direction, b, n, **stalls)
    assert seen.values["affine"] == transfers(model)
    waits = {o - i for i, o in zip(seen.cycles["sums"][3::4], seen.cycles["affine"], strict=True)}
    assert stalls or waits == {dut.latency} == {design.formats.operand + 27}
    return model


def anything(design, seed, frames):
    rng = np.random.default_rng(seed)
    b, n = split(design, random_words(rng, design.widths.vector, (frames, 3, 3)), rng)
    return random_frames(rng, frames), random_direction(design, rng, frames), b, n


@pytest.mark.parametrize("name", ["standard", "short", "operand over vector", *long("wide", "ten")])
def test_real_frames(name):
    design = DESIGNS[name]
    model = check(design, *real_sums(design, random_codes(design, 1, 24 if name == "short" else 12)))
    assert model.alpha.any()
    assert model.beta.any()


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    model = check(DESIGNS[name], *anything(DESIGNS[name], 2, 36))
    assert model.vanishing.any()
    assert not model.vanishing.all()


@pytest.mark.parametrize("name", ["standard", *long("wide", "operand over vector")])
def test_corners(name):
    """Zeros, units and the ends of words, alone and together, in every direction."""
    design = DESIGNS[name]
    top, turn = (1 << (design.widths.vector - 1)) - 1, (1 << (design.formats.operand - 1)) - 1
    exact = [np.full((3, 3), value) for value in (0, 1, -1, top, -top - 1)]
    exact += [np.eye(3, dtype=np.int64) * top, np.eye(3, dtype=np.int64)[::-1] * (-top - 1)]
    exact += [np.array([[top, 1, -1], [-top - 1, top, 0], [0, -top - 1, top]])]
    ways = [(turn, 0), (-turn - 1, 0), (0, -turn - 1), (turn, turn), (-turn - 1, -turn - 1), (-turn - 1, turn), (1, 0)]
    cases = list(product(exact, ways))
    cos, sin = np.array([way for _, way in cases]).T
    sweep_y = np.arange(len(cases)) % 2 == 1
    b, n = split(design, np.array([a for a, _ in cases]), np.random.default_rng(3))
    check(design, regular_frames(len(cases)), Direction(cos, sin, sweep_y, ~sweep_y, sweep_y & False), b, n)


@pytest.mark.parametrize(
    ("name", "sweep_y"), [("standard", True), ("short", False), *long(("standard", False), ("short", True))]
)
def test_limit_of_the_vanishing_denominator(name, sweep_y):
    """Quotients just below two are used, at two they vanish; equal operands give one."""
    design = DESIGNS[name]
    unit, one = 1 << (design.formats.operand - 2), 1 << (design.formats.operand - 3)
    pairs = [(top, other, half) for half in (unit, -unit // 2, unit - 1) for top, other in _around(half)]
    exact = np.zeros((len(pairs), 3, 3), dtype=np.int64)
    # the other row meets a factor of zero
    row, den, num1 = (0, 1, 2) if sweep_y else (1, 2, 1)
    exact[:, row, 0], exact[:, row, num1], exact[:, row, den] = np.array(pairs).T
    zero = np.zeros(len(pairs), dtype=np.int64)
    cos, sin = (zero, zero + unit) if sweep_y else (zero + unit, zero)
    direction = Direction(cos, sin, (zero == 0) & sweep_y, zero > 0, zero > 0)
    b, n = split(design, exact, np.random.default_rng(4))
    model = check(design, regular_frames(len(pairs)), direction, b, n)
    assert {False, True} == set(model.vanishing.tolist())
    assert {one, -one} <= set(np.abs(model.alpha).tolist()) | set(model.beta.tolist())


def _around(half):
    ends = (2 * half - 1, 2 * half, 2 * half + 1, -2 * half - 1, -2 * half, -2 * half + 1, half, -half, 0)
    return [(e, 0) for e in ends] + [(0, e) for e in ends]


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["standard"]
    check(design, *anything(design, 5, 8), stall_in=stall_in, stall_out=stall_out, seed=5)


def test_waits_for_its_facts():
    """Waits much longer than a calculation: every port is the last one at times."""

    def long_waits(rng):
        while True:
            yield from [True] * rng.randrange(100) + [False]

    check(DESIGNS["short"], *anything(DESIGNS["short"], 6, 8), stall_in=long_waits, seed=6)


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, direction, b, n = real_sums(design, random_codes(design, 8, 5))
    seen = send(Dependent(design), frame, direction, b, n)
    n[3, 1, OO] ^= 1 << (design.widths.vector - 6)
    assert seen.values["affine"] != transfers(dependent(design, gather_sums(b, n), direction, frame.regular))
