"""Resultant against its model: real frames, random words, ends of words, stalls and constant time."""

import random

import numpy as np
import pytest

from tests.hdl.parallel.facts import (
    DESIGNS,
    bits_of,
    random_affine,
    random_codes,
    random_frames,
    real_affine,
    transfers,
    words,
)
from tests.marks import STALLS
from tfra.hdl.parallel.tfra.resultant import Resultant
from tfra.model.fixed.normaliser import Normalised
from tfra.model.fixed.tfra.dependent import Dependent
from tfra.model.fixed.tfra.friction import Friction, friction
from tfra.model.fixed.tfra.resultant import resultant
from tfra.sim.harness import run


def inputs(frame, affine, chosen):
    return {"affine": transfers(affine), "chosen": transfers(chosen), "frame": transfers(frame)}


def expected(design, frame, affine, chosen):
    return resultant(design, affine, chosen, frame.regular)


def check(design, frame, affine, chosen, **stalls):
    seen = run(Resultant(design), inputs(frame, affine, chosen), {"total": len(chosen.index)}, **stalls)
    model = expected(design, frame, affine, chosen)
    assert seen.values["total"] == transfers(model), f"seed {stalls.get('seed')}"
    return model


def any_chosen(design, rng, frames):
    index = np.array([rng.randrange(design.candidates) for _ in range(frames)])
    return Friction(index, *words(rng, design.formats.operand, (3, frames)), bits_of(rng, frames))


def anything(design, seed, frames):
    rng = random.Random(seed)
    frame, affine = random_frames(design, rng, frames), random_affine(design, rng, frames)
    return frame, affine, any_chosen(design, rng, frames)


@pytest.mark.parametrize("name", DESIGNS)
def test_real_frames(name):
    design = DESIGNS[name]
    frame, direction, affine = real_affine(design, random_codes(design, 1, 24))
    index = np.random.default_rng(1).integers(0, design.candidates, 24)
    chosen = friction(design, index, direction, affine, frame.regular)
    model = check(design, frame, affine, chosen, seed=1)
    assert (model.words[~frame.regular, :2] == 0).all()
    assert (model.words[frame.regular, :2] != 0).any()


@pytest.mark.parametrize("name", DESIGNS)
def test_any_words(name):
    check(DESIGNS[name], *anything(DESIGNS[name], 2, 80), seed=2)


@pytest.mark.parametrize("name", ["standard", "short"])
def test_corners(name):
    """Zeros, units and the ends of words in every place."""
    design = DESIGNS[name]
    top = (1 << (design.formats.operand - 1)) - 1
    ends = (0, 1, -1, top, -top - 1)
    cases = [(start, slope, mu) for start in ends for slope in ends for mu in ends]
    number = len(cases)
    start, slope, mu = np.array(cases).T
    sums = np.stack([np.stack([start, slope, slope], axis=1)] * 3, axis=1)
    sums[:, 1, 1] = -1 - sums[:, 1, 1]
    sums[:, 2] = np.roll(sums[:, 2], 1, axis=0)
    zero, true = np.zeros(number, dtype=np.int64), np.ones(number, dtype=np.bool_)
    regular = np.arange(number) % 3 > 0
    significant = np.where(regular, 0, design.widths.vector - 1)
    frame = Normalised(zero[:, None], zero, zero, true, regular, ~true)
    check(
        design,
        frame,
        Dependent(zero, zero, ~true, sums, significant),
        Friction(zero, zero, mu, np.roll(mu, 1) if name == "short" else mu, ~true),
    )


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    design = DESIGNS["wide"]
    check(design, *anything(design, 4, 12), stall_in=stall_in, stall_out=stall_out, seed=4)


@pytest.mark.parametrize("name", DESIGNS)
def test_latency(name):
    dut = Resultant(DESIGNS[name])
    seen = run(dut, inputs(*anything(DESIGNS[name], 5, 8)), {"total": 8})
    assert {o - i for i, o in zip(seen.cycles["chosen"], seen.cycles["total"], strict=True)} == {dut.latency}


def test_a_wrong_bit_is_noticed():
    design = DESIGNS["standard"]
    frame, affine, chosen = anything(design, 6, 6)
    frame.contact[2] = frame.traction[2] = True
    affine.sums[2], chosen.mu_x[2] = 1 << 12, 1 << 12
    seen = run(Resultant(design), inputs(frame, affine, chosen), {"total": 6})
    affine.sums[2, 1, 0] ^= 1 << 8
    assert seen.values["total"] != transfers(expected(design, frame, affine, chosen))
