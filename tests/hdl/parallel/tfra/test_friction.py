"""Friction against its model: every candidate, saturation, stalls and constant time."""

from itertools import product

import numpy as np
import pytest

from tests.hdl.parallel.facts import (
    DESIGNS,
    random_affine,
    random_codes,
    random_direction,
    random_frames,
    real_affine,
    regular_frames,
    transfers,
)
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.friction import Friction
from tfra.model.fixed.tfra.centroids import Direction
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import friction
from tfra.model.fixed.widths import scalar_fraction
from tfra.sim.harness import run


def send(dut, frame, direction, affine, index, **stalls):
    facts = {"direction": transfers(direction), "affine": transfers(affine), "frame": transfers(frame)}
    return run(dut, {"index": index.tolist(), **facts}, {"chosen": len(index)}, **stalls)


def check(design, frame, direction, affine, index, **stalls):
    """Words, and the latency when nothing stalls; returns the model's facts."""
    dut, model = Friction(design), friction(design, index, direction, affine, frame.regular)
    seen = send(dut, frame, direction, affine, index, **stalls)
    assert seen.values["chosen"] == transfers(model)
    waits = {o - i for i, o in zip(seen.cycles["index"], seen.cycles["chosen"], strict=True)}
    assert stalls or waits == {dut.latency}
    return model


def anything(design, seed, frames):
    rng = np.random.default_rng(seed)
    facts = random_frames(rng, frames), random_direction(design, rng, frames), random_affine(design, rng, frames)
    ends = rng.choice([0, 1, design.search.steps], frames)
    return *facts, np.where(rng.random(frames) < 0.75, ends, rng.integers(0, design.candidates, frames))


@pytest.mark.parametrize("name", DESIGNS)
def test_real_frames(name):
    design = DESIGNS[name]
    facts = real_affine(design, random_codes(design, 1, 24))
    check(design, *facts, np.random.default_rng(1).integers(0, design.candidates, 24))


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    model = check(DESIGNS[name], *anything(DESIGNS[name], 2, 80))
    assert model.out_of_range.any()
    assert not model.out_of_range.all()


def test_every_candidate_of_both_signs():
    design = DESIGNS["standard"]
    index = np.tile(np.arange(design.candidates), 2)
    number = len(index)
    zero, negative = np.zeros(number, dtype=np.int64), np.arange(number) < design.candidates
    direction = Direction(zero, zero, index % 2 == 0, negative, zero > 0)
    affine = random_affine(design, np.random.default_rng(3), number)
    model = check(design, regular_frames(number), direction, affine, index)
    one = 1 << scalar_fraction(design)
    assert model.mu_ind[[0, 100, 101, 201]].tolist() == [-one, 0, 0, one]


@pytest.mark.parametrize("name", ["standard", "short"])
def test_limits_of_mu_dep(name):
    """Saturation on both sides, and +-1, the limits of the range."""
    design = DESIGNS[name]
    one = 1 << scalar_fraction(design)
    ends = (-4 * one, 1 - 4 * one, -one - 1, -one, 1 - one, -1, 0, 1, one - 1, one, one + 1, 4 * one - 1)
    alpha, beta = np.array(list(product(ends, ends))).T
    number, zero = len(alpha), np.zeros_like(alpha)
    sweep_y, negative = np.arange(number) % 2 == 0, np.arange(number) % 4 >= 2
    affine = Dependent(alpha, beta, zero > 0, np.zeros((number, 3, 3), dtype=np.int64), zero)
    index = np.where(negative, 0, design.search.steps)
    model = check(design, regular_frames(number), Direction(zero, zero, sweep_y, negative, zero > 0), affine, index)
    mu_dep = np.where(sweep_y, model.mu_x, model.mu_y)
    assert {-4 * one, 4 * one - 1, one, -one} <= set(mu_dep.tolist())
    assert not model.out_of_range[np.abs(mu_dep) == one].any()


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["wide"]
    check(design, *anything(design, 5, 16), stall_in=stall_in, stall_out=stall_out, seed=5)


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, direction, affine, index = anything(design, 7, 6)
    seen = send(Friction(design), frame, direction, affine, index)
    affine.alpha[4] ^= 1
    assert seen.values["chosen"] != transfers(friction(design, index, direction, affine, frame.regular))
