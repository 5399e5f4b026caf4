"""Resultant against its model: real frames, random words, ends of words, stalls and constant time."""

from itertools import product

import numpy as np
import pytest

from tests.hdl.parallel.designs import random_words
from tests.hdl.parallel.facts import (
    DESIGNS,
    frame_facts,
    random_affine,
    random_codes,
    random_frames,
    real_affine,
    transfers,
)
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.resultant import Resultant
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import Friction, friction
from tfra.model.fixed.tfra.resultant import resultant
from tfra.sim.harness import run


def send(dut, frame, affine, chosen, **stalls):
    facts = {"affine": transfers(affine), "chosen": transfers(chosen), "frame": transfers(frame)}
    return run(dut, facts, {"total": len(chosen.index)}, **stalls)


def check(design, frame, affine, chosen, **stalls):
    """Words, and the latency when nothing stalls; returns the model's facts."""
    dut, model = Resultant(design), resultant(design, affine, chosen, frame.regular)
    seen = send(dut, frame, affine, chosen, **stalls)
    assert seen.values["total"] == transfers(model)
    waits = {o - i for i, o in zip(seen.cycles["chosen"], seen.cycles["total"], strict=True)}
    assert stalls or waits == {dut.latency}
    return model


def anything(design, seed, frames):
    rng = np.random.default_rng(seed)
    mu = random_words(rng, design.formats.operand, (3, frames))
    chosen = Friction(rng.integers(0, design.candidates, frames), *mu, rng.random(frames) < 0.5)
    return random_frames(rng, frames), random_affine(design, rng, frames), chosen


@pytest.mark.parametrize("name", DESIGNS)
def test_real_frames(name):
    design = DESIGNS[name]
    frame, direction, affine = real_affine(design, random_codes(design, 1, 24))
    index = np.random.default_rng(1).integers(0, design.candidates, 24)
    model = check(design, frame, affine, friction(design, index, direction, affine, frame.regular))
    assert (model.words[~frame.regular, :2] == 0).all()
    assert (model.words[frame.regular, :2] != 0).any()


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    check(DESIGNS[name], *anything(DESIGNS[name], 2, 80))


@pytest.mark.parametrize("name", ["standard", "short"])
def test_corners(name):
    """Zeros, units and the ends of words in every place."""
    design = DESIGNS[name]
    top = (1 << (design.formats.operand - 1)) - 1
    start, slope, mu = np.array(list(product((0, 1, -1, top, -top - 1), repeat=3))).T
    sums = np.stack([np.stack([start, slope, slope], axis=1)] * 3, axis=1)
    sums[:, 1, 1] = -1 - sums[:, 1, 1]
    sums[:, 2] = np.roll(sums[:, 2], 1, axis=0)
    zero, regular = np.zeros_like(mu), np.arange(len(mu)) % 3 > 0
    affine = Dependent(zero, zero, zero > 0, sums, np.where(regular, 0, design.widths.vector - 1))
    chosen = Friction(zero, zero, mu, np.roll(mu, 1) if name == "short" else mu, zero > 0)
    check(design, frame_facts(zero == 0, regular), affine, chosen)


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["wide"]
    check(design, *anything(design, 4, 12), stall_in=stall_in, stall_out=stall_out, seed=4)


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, affine, chosen = anything(design, 6, 6)
    frame.contact[2] = frame.traction[2] = True
    affine.sums[2], chosen.mu_x[2] = 1 << 12, 1 << 12
    seen = send(Resultant(design), frame, affine, chosen)
    affine.sums[2, 1, 0] ^= 1 << 8
    assert seen.values["total"] != transfers(resultant(design, affine, chosen, frame.regular))
