"""Dependent against its model: real frames, random words, every limit, stalls and constant time."""

import random

import numpy as np
import pytest

from tests.hdl.parallel.facts import (
    DESIGNS,
    random_codes,
    random_direction,
    random_frames,
    real_sums,
    transfers,
    words,
)
from tests.marks import STALLS, long
from tfra.hdl.parallel.tfra.dependent import Dependent
from tfra.model.fixed.butterfly import EE, OO, OX, OY
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.tfra.dependent import dependent, gather_sums
from tfra.sim.harness import run


def split(design, exact, rng):
    """Sum quads whose A_pq are ``exact (n, 3, 3)``; the words they do not use are noise."""
    bits = design.widths.vector
    low, high = -1 << (bits - 1), (1 << (bits - 1)) - 1
    b, n = words(rng, bits, (len(exact), 1, 4)), words(rng, bits, (len(exact), 3, 4))
    for row, parity, quad, place in ((0, OX, 0, OX), (1, OY, 0, OY), (2, EE, 2, EE)):
        part = np.array([rng.randint(max(low, int(a) - high), min(high, int(a) - low)) for a in exact[:, row, 0]])
        b[:, 0, parity], n[:, quad, place] = part, exact[:, row, 0] - part
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


def inputs(frame, direction, b, n):
    return {
        "sums": np.concatenate([b, n], axis=1).reshape(-1, 4).tolist(),
        "direction": transfers(direction),
        "frame": transfers(frame),
    }


def expected(design, frame, direction, b, n):
    return dependent(design, gather_sums(b, n), direction, frame.regular)


def check(design, frame, direction, b, n, **stalls):
    seen = run(Dependent(design), inputs(frame, direction, b, n), {"affine": len(b)}, **stalls)
    model = expected(design, frame, direction, b, n)
    assert seen.values["affine"] == transfers(model), f"seed {stalls.get('seed')}"
    return model


def anything(design, seed, frames):
    rng = random.Random(seed)
    exact = words(rng, design.widths.vector, (frames, 3, 3))
    b, n = split(design, exact, rng)
    return random_frames(design, rng, frames), random_direction(design, rng, frames), b, n


@pytest.mark.parametrize("name", ["standard", "short", "operand over vector", *long("wide", "ten")])
def test_real_frames(name):
    design = DESIGNS[name]
    model = check(design, *real_sums(design, random_codes(design, 1, 24 if name == "short" else 12)), seed=1)
    assert model.alpha.any()
    assert model.beta.any()


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    model = check(DESIGNS[name], *anything(DESIGNS[name], 2, 36), seed=2)
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
    cases = [(a, c, s) for a in exact for c, s in ways]
    count = len(cases)
    zero, one = np.zeros(count, dtype=np.int64), np.ones(count, dtype=np.bool_)
    cos, sin = np.array([c for _, c, _ in cases]), np.array([s for _, _, s in cases])
    sweep_y = np.arange(count) % 2 == 1
    direction = Direction(cos, sin, sweep_y, ~sweep_y, ~one)
    frame = Normalised(zero[:, None], zero, zero, one, one, ~one)
    b, n = split(design, np.array([a for a, _, _ in cases]), random.Random(3))
    check(design, frame, direction, b, n, seed=3)


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
    zero, true = np.zeros(len(pairs), dtype=np.int64), np.ones(len(pairs), dtype=np.bool_)
    turn = np.full(len(pairs), unit)
    cos, sin = (zero, turn) if sweep_y else (turn, zero)
    direction = Direction(cos, sin, true & sweep_y, ~true, ~true)
    frame = Normalised(zero[:, None], zero, zero, true, true, ~true)
    b, n = split(design, exact, random.Random(4))
    model = check(design, frame, direction, b, n, seed=4)
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


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    design = DESIGNS[name]
    dut = Dependent(design)
    sent = anything(design, 7, 6)
    seen = run(dut, inputs(*sent), {"affine": 6})
    last = seen.cycles["sums"][3::4]
    assert {out - i for i, out in zip(last, seen.cycles["affine"], strict=True)} == {dut.latency}
    assert dut.latency == design.formats.operand + 27


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, direction, b, n = real_sums(design, random_codes(design, 8, 5))
    seen = run(Dependent(design), inputs(frame, direction, b, n), {"affine": 5})
    n[3, 1, OO] ^= 1 << (design.widths.vector - 6)
    assert seen.values["affine"] != transfers(expected(design, frame, direction, b, n))
