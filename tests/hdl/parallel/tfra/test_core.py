"""The whole core in Amaranth's simulator: bit-exact results, and the latency and interval that Timing states."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from amaranth import ResetInserter, Signal
from amaranth.sim import Simulator

from tests.hdl.parallel.tfra.streamed import mixed_design, random_design, stream
from tests.marks import long
from tfra.hdl.parallel.matvec.schedule import Schedule
from tfra.hdl.parallel.tfra.core import TfraCore
from tfra.hdl.parallel.tfra.parallel import TfraParallel
from tfra.model.choices import FORMATS, Adc, Architecture, Search
from tfra.model.cover.scenes import contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.operators import STACKS
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.rounding import Rounding
from tfra.model.sensor import SensorArray
from tfra.sim.harness import bursts, flowing, random_stalls

CASES = [
    (
        TfraDesign(SensorArray(4, 4, 4e-3, 2e-3, 3e-3), search=Search(20), architecture=Architecture(4)),
        flowing,
        flowing,
    ),
    (
        TfraDesign(SensorArray(5, 7, 3e-3, 3e-3, 2e-3), search=Search(16), architecture=Architecture(48)),
        random_stalls,
        flowing,
    ),
    (TfraDesign(SensorArray(2, 3, 2e-3, 3e-3, 2e-3), search=Search(5), architecture=Architecture(4)), flowing, bursts),
    (
        TfraDesign(
            SensorArray(3, 5, 1.27e-3, 2.54e-3, 2e-3),
            adc=Adc(16),
            search=Search(9, 2.5),
            formats=FORMATS["wide"],
            architecture=Architecture(4),
        ),
        bursts,
        random_stalls,
    ),
    (  # folded codes longer than an operand
        TfraDesign(SensorArray(4, 3, 4e-3, 2e-3, 3e-3), adc=Adc(18), search=Search(7), architecture=Architecture(8, 2)),
        bursts,
        bursts,
    ),
    *(
        (
            TfraDesign(
                SensorArray(2, 3, 2e-3, 3e-3, 2e-3),
                search=Search(5),
                formats=replace(FORMATS["standard"], rounding=rounding),
                architecture=Architecture(4),
            ),
            flowing,
            flowing,
        )
        for rounding in Rounding
        if rounding is not Rounding.HALF_UP
    ),
]


@pytest.mark.parametrize(("design", "stall_in", "stall_out"), [CASES[2], *long(*CASES[:2], *CASES[3:])])
def test_every_word_equals_the_model(design, stall_in, stall_out):
    directed = directed_codes(design)
    scenes = contact_codes(design, 3, seed=1), directed[:7], directed[-4:], wild_codes(design, 2, seed=2)
    codes = np.concatenate(scenes)
    words, want, last, *_ = stream(design, codes, stall_in=stall_in, stall_out=stall_out, seed=3)
    names = [f.name for f in design.layout for _ in range(f.count)]
    bad = np.argwhere(words != want)
    assert not len(bad), f"frame {bad[0][0]}, {names[bad[0][1]]}, word {bad[0][1]}"
    assert last[:, -1].all()
    assert last.sum() == len(want)


def sleepy(rng):
    """Asleep for longer than frames take, then awake for a while, so that every place in the core fills up."""
    while True:
        yield from [True] * rng.randrange(2000)
        yield from [False] * rng.randrange(1, 400)


@pytest.mark.parametrize("seed", long(18, 19, 20))
def test_everything_has_its_place_while_the_output_sleeps(seed):
    """Nothing behind the products asks for a place: tokens alone see to it that there is one."""
    design = random_design(seed)
    words, want, *_ = stream(design, contact_codes(design, 9, seed), stall_out=sleepy, seed=seed)
    assert (words == want).all()


@pytest.mark.parametrize(("seed", "held"), long((22, 1), (21, 1), (23, 1), (21, 4), (22, 4), (23, 4)))
def test_a_reset_at_any_time_forgets_all(seed, held):
    """Only control is cleared: sums run on, words and memories keep what they hold, and no later frame shows it."""
    design, rng = random_design(seed), random.Random(seed)
    codes = contact_codes(design, 3, seed)
    want, reset = FixedTfra(design)(codes).words.ravel(), Signal()
    core, found = TfraCore(design), []
    timing = TfraParallel(design)
    interrupted = [rng.randrange(1, timing.frame_latency + 3 * timing.initiation_interval) for _ in range(2)]

    async def bench(ctx):
        for cycles in interrupted:
            ctx.set(core.taxel.valid, 1)
            for _ in range(cycles):
                ctx.set(core.taxel.payload, rng.randrange(-30_000, 30_000))
                ctx.set(core.result.ready, rng.random() < 0.7)
                await ctx.tick()
            ctx.set(core.taxel.valid, 0)
            ctx.set(reset, 1)
            for _ in range(held):
                await ctx.tick()
            ctx.set(reset, 0)
        ctx.set(core.result.ready, 1)
        taxels = codes.ravel().tolist()
        for _ in range(codes[0].size * 3 + timing.frame_latency + 8 * timing.initiation_interval):
            ctx.set(core.taxel.valid, bool(taxels))
            ctx.set(core.taxel.payload, taxels[0] if taxels else 0)
            _, _, taken, valid, word = await ctx.tick().sample(core.taxel.ready, core.result.valid, core.result.payload)
            if taken and taxels:
                taxels.pop(0)
            if valid:
                found.append(word["data"])

    simulator = Simulator(ResetInserter(reset)(core))
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == want.tolist(), f"after resets at {interrupted}"


@pytest.mark.parametrize("seed", [2, *long(0, 1, 3, 4, 10, 5, 6, 7, 8, 9, 11)])
def test_timing_is_what_the_gateware_does(seed):
    """Every taxel and every word of frames back to back comes in the cycle that the timeline says."""
    check_timing(random_design(seed), seed)


@pytest.mark.parametrize("seed", [2, *long(0, 1, 3, 4, 6, 7, 8, 10, 12)])
def test_signals_with_word_lengths_of_their_own(seed):
    check_timing(mixed_design(seed), seed)


def check_timing(design, seed):
    codes = contact_codes(design, 8, seed)
    words, want, _, taken, cycles = stream(design, codes)
    timeline = TfraParallel(design).timeline(len(codes))
    assert (words == want).all()
    start = taken[0]
    assert (taken - start).tolist() == [frame.taxel for frame in timeline.frames]
    assert (cycles - start).tolist() == [frame.words for frame in timeline.frames]


@pytest.mark.parametrize("seed", [13, *long(12, 14, 15, 16, 17)])
def test_a_single_frame_takes_the_stated_latency(seed):
    design = random_design(seed)
    words, want, _, taken, cycles = stream(design, contact_codes(design, 1, seed))
    timing = TfraParallel(design)
    assert (words == want).all()
    assert cycles[0, 0] - taken[0] == timing.latency
    assert cycles[0, -1] - taken[0] == timing.frame_latency


@pytest.mark.parametrize("seed", [4, *long(0, 14)])
def test_products_begin_when_the_timeline_says(seed, monkeypatch):
    """The order of products that docs/studies/schedule.md describes is what the lanes do, cycle by cycle."""
    seen = []
    elaborate = Schedule.elaborate

    def watched(self, platform):
        m = elaborate(self, platform)
        seen.append(self)
        return m

    monkeypatch.setattr(Schedule, "elaborate", watched)
    design = random_design(seed)
    codes = contact_codes(design, 6, seed)
    launches, taxels = launched(design, codes, seen)
    start = taxels[design.sensor.taxels - 1]
    timeline = TfraParallel(design).timeline(len(codes))
    assert [(cycle - start, stack) for cycle, stack in launches] == timeline.products.launches[: len(launches)]
    assert len(launches) == 5 * len(codes)


def launched(design, codes, seen):
    """Cycles and stacks of all products, and cycles of all taxels."""
    core, launches, taxels = TfraCore(design), [], []
    simulator = Simulator(core)
    simulator.add_clock(1e-6)

    async def bench(ctx):
        flat = codes.ravel().tolist()
        ctx.set(core.result.ready, 1)
        ctx.set(core.taxel.valid, 1)
        cycle = 0
        while len(launches) < 5 * len(codes):
            if len(taxels) < len(flat):
                ctx.set(core.taxel.payload, flat[len(taxels)])
            else:
                ctx.set(core.taxel.valid, 0)
            schedule = seen[-1]
            sampled = core.taxel.valid & core.taxel.ready, schedule.launch & schedule.new, schedule.stack
            _, _, taken, launch, stack = await ctx.tick().sample(*sampled)
            if taken:
                taxels.append(cycle)
            if launch:
                launches.append((cycle, STACKS[stack]))
            cycle += 1

    simulator.add_testbench(bench)
    simulator.run()
    return launches, taxels


def test_a_wrong_coefficient_is_noticed(monkeypatch):
    """The comparison is not blind: one coefficient memory that differs from the model's changes words."""
    design = TfraDesign(SensorArray(4, 4, 4e-3, 2e-3, 3e-3), search=Search(20), architecture=Architecture(4))
    from tfra.hdl.parallel.matvec import unit as matvec

    def corrupted(design):
        images = original(design).copy()
        images[1, 0] ^= 1 << 10
        return images

    original = matvec.lane_images
    monkeypatch.setattr(matvec, "lane_images", corrupted)
    words, want, *_ = stream(design, contact_codes(design, 1, seed=1))
    assert (words != want).any()
