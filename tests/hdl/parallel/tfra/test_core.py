"""The whole core in Amaranth's simulator: bit-exact results, and the latency and interval that its timeline states."""

import random
from dataclasses import replace
from operator import mul

import numpy as np
import pytest

from tests.hdl.parallel.cores import check_resets, check_single_frame, check_timing, check_words, sleepy, stream
from tests.hdl.parallel.designs import make, mixed_design, random_design, simulate
from tests.marks import long
from tfra.hdl.parallel.matvec import images
from tfra.hdl.parallel.matvec import unit as matvec
from tfra.hdl.parallel.matvec.schedule import Schedule
from tfra.hdl.parallel.tfra.core import TfraCore, TfraParallel
from tfra.model.choices import FORMATS
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.operators import STACKS
from tfra.model.rounding import Rounding
from tfra.sim.harness import bursts, flowing, random_stalls

CASES = [
    (make(4, 4, steps=20), flowing, flowing),
    (make(5, 7, steps=16, lanes=48, pitches=(3, 3), thickness=2), random_stalls, flowing),
    (make(2, 3, steps=5, pitches=(2, 3), thickness=2), flowing, bursts),
    (make(3, 5, "wide", bits=16, steps=9, tolerance=2.5, pitches=(1.27, 2.54), thickness=2), bursts, random_stalls),
    (make(4, 3, bits=18, steps=7, lanes=8, words=2), bursts, bursts),  # folded codes longer than an operand
    *(
        (make(2, 3, replace(FORMATS["standard"], rounding=rounding), steps=5, thickness=2), flowing, flowing)
        for rounding in Rounding
        if rounding is not Rounding.HALF_UP
    ),
]


@pytest.mark.parametrize(("design", "stall_in", "stall_out"), [CASES[2], *long(CASES[0], CASES[3], CASES[5])])
def test_every_word_equals_the_model(design, stall_in, stall_out):
    directed = directed_codes(design)
    scenes = contact_codes(design, 2, seed=1), directed[:6], directed[-3:], wild_codes(design, 1, seed=2)
    check_words(design, np.concatenate(scenes), stall_in=stall_in, stall_out=stall_out, seed=3)


@pytest.mark.parametrize("seed", long(18))
def test_everything_has_its_place_while_the_output_sleeps(seed):
    """Nothing behind the products asks for a place: tokens alone see to it that there is one."""
    design = random_design(seed)
    check_words(design, contact_codes(design, 9, seed), stall_out=sleepy, seed=seed)


@pytest.mark.parametrize(("seed", "held"), long((22, 1), (23, 4)))
def test_a_reset_at_any_time_forgets_all(seed, held):
    """Only control is cleared: sums run on, words and memories keep what they hold, and no later frame shows it."""
    design, rng = random_design(seed), random.Random(seed)
    timing = TfraParallel(design)
    interrupted = [rng.randrange(1, timing.frame_latency + 3 * timing.initiation_interval) for _ in range(2)]
    check_resets(design, contact_codes(design, 3, seed), interrupted, held, rng)


@pytest.mark.parametrize("seed", [2, *long(0, 9)])
def test_timing_is_what_the_gateware_does(seed):
    design = random_design(seed)
    check_timing(design, contact_codes(design, 8, seed))


@pytest.mark.parametrize(("seed", "tail"), long((0, True), (10, False), (10, True)))
def test_signals_with_word_lengths_of_their_own(seed, tail, monkeypatch):
    """With a ``tail``, as if every bit of a memory had its cost, and not only whole block memories."""
    if tail:
        monkeypatch.setattr(images, "memories", mul)
    design = mixed_design(seed)
    assert (images.tail(design).bits > 0) == tail
    check_timing(design, contact_codes(design, 6, seed))


@pytest.mark.parametrize("seed", long(12))
def test_a_single_frame_takes_the_stated_latency(seed):
    design = random_design(seed)
    check_single_frame(design, contact_codes(design, 1, seed))


@pytest.mark.long
@pytest.mark.parametrize("seed", [4, 0])
def test_products_begin_when_the_timeline_says(seed, monkeypatch):
    """The order of products that docs/studies/schedule.md describes is what the lanes do, cycle by cycle."""
    schedules = []
    elaborate = Schedule.elaborate

    def watched(self, platform):
        schedules.append(self)
        return elaborate(self, platform)

    monkeypatch.setattr(Schedule, "elaborate", watched)
    design = random_design(seed)
    codes = contact_codes(design, 4, seed)
    launches, taxels = launched(design, codes, schedules)
    start = taxels[design.sensor.taxels - 1]
    stated = TfraParallel(design).timeline(len(codes)).products.launches
    assert [(cycle - start, stack) for cycle, stack in launches] == stated[: len(launches)]
    assert len(launches) == 5 * len(codes)


def launched(design, codes, schedules):
    """Cycles and stacks of all products, and cycles of all taxels."""
    core, launches, taxels = TfraCore(design), [], []

    async def bench(ctx):
        flat = codes.ravel().tolist()
        ctx.set(core.result.ready, 1)
        cycle = 0
        while len(launches) < 5 * len(codes):
            ctx.set(core.taxel.valid, len(taxels) < len(flat))
            ctx.set(core.taxel.payload, flat[min(len(taxels), len(flat) - 1)])
            schedule = schedules[-1]
            sampled = core.taxel.valid & core.taxel.ready, schedule.launch & schedule.new, schedule.stack
            _, _, taken, launch, stack = await ctx.tick().sample(*sampled)
            if taken:
                taxels.append(cycle)
            if launch:
                launches.append((cycle, STACKS[stack]))
            cycle += 1

    simulate(core, bench)
    return launches, taxels


def test_a_wrong_coefficient_is_noticed(monkeypatch):
    """The comparison is not blind: one coefficient memory that differs from the model's changes words."""
    original = matvec.lane_images

    def corrupted(design):
        images = original(design).copy()
        images[1, 0] ^= 1 << 10
        return images

    monkeypatch.setattr(matvec, "lane_images", corrupted)
    design = CASES[2][0]
    words, want, *_ = stream(design, contact_codes(design, 1, seed=1))
    assert (words != want).any()
