"""Friction against its model: every candidate, saturation, stalls and constant time."""

import random

import numpy as np
import pytest

from tests.hdl.parallel.facts import (
    DESIGNS,
    random_affine,
    random_codes,
    random_direction,
    random_frames,
    real_affine,
    transfers,
)
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.friction import Friction
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import friction
from tfra.sim.harness import run


def inputs(frame, direction, affine, index):
    return {
        "index": index.tolist(),
        "direction": transfers(direction),
        "affine": transfers(affine),
        "frame": transfers(frame),
    }


def expected(design, frame, direction, affine, index):
    return friction(design, index, direction, affine, frame.regular)


def check(design, frame, direction, affine, index, **stalls):
    seen = run(Friction(design), inputs(frame, direction, affine, index), {"chosen": len(index)}, **stalls)
    model = expected(design, frame, direction, affine, index)
    assert seen.values["chosen"] == transfers(model), f"seed {stalls.get('seed')}"
    return model


def anything(design, seed, frames):
    rng = random.Random(seed)
    facts = (random_frames(design, rng, frames), random_direction(design, rng, frames))
    index = np.array([rng.choice([0, 1, design.search.steps, rng.randrange(design.candidates)]) for _ in range(frames)])
    return *facts, random_affine(design, rng, frames), index


@pytest.mark.parametrize("name", DESIGNS)
def test_real_frames(name):
    design = DESIGNS[name]
    facts = real_affine(design, random_codes(design, 1, 24))
    index = np.random.default_rng(1).integers(0, design.candidates, 24)
    check(design, *facts, index, seed=1)


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    model = check(DESIGNS[name], *anything(DESIGNS[name], 2, 80), seed=2)
    assert model.out_of_range.any()
    assert not model.out_of_range.all()


def test_every_candidate_of_both_signs():
    design = DESIGNS["standard"]
    index = np.tile(np.arange(design.candidates), 2)
    number = len(index)
    rng = random.Random(3)
    zero, true = np.zeros(number, dtype=np.int64), np.ones(number, dtype=np.bool_)
    frame = Normalised(zero[:, None], zero, zero, true, true, ~true)
    direction = Direction(zero, zero, index % 2 == 0, np.arange(number) < design.candidates, ~true)
    model = check(design, frame, direction, random_affine(design, rng, number), index, seed=3)
    one = 1 << scalar_fraction(design)
    assert (model.mu_ind[0], model.mu_ind[100], model.mu_ind[101], model.mu_ind[201]) == (-one, 0, 0, one)


@pytest.mark.parametrize("name", ["standard", "short"])
def test_limits_of_mu_dep(name):
    """Saturation on both sides, and +-1, the limits of the range."""
    design = DESIGNS[name]
    one = 1 << scalar_fraction(design)
    ends = (-4 * one, 1 - 4 * one, -one - 1, -one, 1 - one, -1, 0, 1, one - 1, one, one + 1, 4 * one - 1)
    pairs = [(a, b) for a in ends for b in ends]
    number = len(pairs)
    alpha, beta = np.array(pairs).T
    zero, true = np.zeros(number, dtype=np.int64), np.ones(number, dtype=np.bool_)
    sweep_y, negative = np.arange(number) % 2 == 0, np.arange(number) % 4 >= 2
    frame = Normalised(zero[:, None], zero, zero, true, true, ~true)
    index = np.where(negative, 0, design.search.steps)
    affine = Dependent(alpha, beta, ~true, np.zeros((number, 3, 3), dtype=np.int64), zero)
    model = check(design, frame, Direction(zero, zero, sweep_y, negative, ~true), affine, index)
    mu_dep = np.where(sweep_y, model.mu_x, model.mu_y)
    assert {-4 * one, 4 * one - 1, one, -one} <= set(mu_dep.tolist())
    assert not model.out_of_range[np.abs(mu_dep) == one].any()


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["wide"]
    check(design, *anything(design, 5, 16), stall_in=stall_in, stall_out=stall_out, seed=5)


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    dut = Friction(DESIGNS[name])
    seen = run(dut, inputs(*anything(DESIGNS[name], 6, 8)), {"chosen": 8})
    assert {o - i for i, o in zip(seen.cycles["index"], seen.cycles["chosen"], strict=True)} == {dut.latency}


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, direction, affine, index = anything(design, 7, 6)
    seen = run(Friction(design), inputs(frame, direction, affine, index), {"chosen": 6})
    affine.alpha[4] ^= 1
    assert seen.values["chosen"] != transfers(expected(design, frame, direction, affine, index))
