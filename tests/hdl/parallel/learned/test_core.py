"""The whole core in Amaranth's simulator: bit-exact results, and the latency and interval that its timeline states."""

import random
from dataclasses import replace
from operator import mul
from pathlib import Path

import numpy as np
import pytest

from tests.hdl.parallel.cores import check_resets, check_single_frame, check_timing, check_words, sleepy, stream
from tests.hdl.parallel.designs import simulate
from tests.hdl.parallel.learned.designs import mixed_design, random_design
from tests.marks import long
from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.hdl.parallel.learned import timeline
from tfra.hdl.parallel.learned.core import LearnedCore, LearnedParallel
from tfra.hdl.parallel.learned.plan import FRAMES, plan
from tfra.hdl.parallel.matvec import images
from tfra.model.choices import FORMATS, Adc, Architecture
from tfra.model.fixed.learned.pipeline import Stage
from tfra.sim.harness import bursts, flowing, random_stalls, run
from tfra.sim.run import simulate as simulate_core

CASES = [
    (learned_design(2, 2, (3, 2), 1), bursts, flowing),
    (learned_design(3, 5, (4, 3), 2, formats=FORMATS["wide"], architecture=Architecture(8, 2)), random_stalls, bursts),
    (learned_design(5, 4, (8, 4), 3, lanes=12, taxel_forces=False), flowing, random_stalls),
    (learned_design(7, 7, (8, 4), 4, lanes=20), flowing, flowing),
    (learned_design(4, 3, (2, 3), 5, adc=Adc(18), architecture=Architecture(16, 1)), bursts, bursts),
]


@pytest.mark.parametrize(("design", "stall_in", "stall_out"), [CASES[0], *long(*CASES[1:])])
def test_every_word_equals_the_model(design, stall_in, stall_out):
    check_words(design, codes_of(design, 9, seed=1), stall_in=stall_in, stall_out=stall_out, seed=3)


@pytest.mark.parametrize(("seed", "forces"), long((21, False), (22, True)))
def test_everything_has_its_place_while_the_output_sleeps(seed, forces):
    """Nothing behind the products asks for a place: tokens alone see to it that there is one."""
    design = random_design(seed, taxel_forces=forces)
    check_words(design, codes_of(design, 9, seed), stall_out=sleepy, seed=seed)


@pytest.mark.parametrize("seed", [2, *long(3, 11, 31, 33)])
def test_timing_is_what_the_gateware_does(seed):
    design = random_design(seed)
    check_timing(design, codes_of(design, 8, seed))


@pytest.mark.parametrize(("seed", "tail"), long((104, True), (112, False), (112, True)))
def test_signals_with_word_lengths_of_their_own(seed, tail, monkeypatch):
    """With a ``tail``, as if every bit of a memory had its cost, and not only whole block memories."""
    if tail:
        monkeypatch.setattr(images, "memories", mul)
    design = mixed_design(seed)
    assert (images.tail(design).bits > 0) == tail
    check_timing(design, codes_of(design, 8, seed))


@pytest.mark.parametrize("seed", long(2))
def test_a_single_frame_takes_the_stated_latency(seed):
    design = random_design(seed)
    check_single_frame(design, codes_of(design, 2, seed)[1:])


@pytest.mark.long
@pytest.mark.parametrize("forces", [False, True])
def test_a_reset_of_one_cycle_in_the_middle_of_anything(forces):
    design, rng = learned_design(3, 2, (3, 2), 7, taxel_forces=forces), random.Random(5)
    length = LearnedParallel(design).frame_latency
    interrupted = [1, *(rng.randrange(6, 2 * length) for _ in range(4))]
    check_resets(design, codes_of(design, 3, 9), interrupted, 1, rng)


@pytest.mark.parametrize("stall_in", [flowing, *long(bursts)])
def test_coefficients_may_be_loaded(stall_in):
    design = learned_design(2, 3, (2, 1), 8, images="load", lanes=8)
    codes = codes_of(design, 5, 3)[3:]
    want = design.model(codes).words
    load = LearnedParallel(design).loaded.tolist()
    inputs = {"load": load, "taxel": codes.ravel().tolist()}
    seen = run(LearnedCore(design), inputs, {"result": want.size}, stall_in=stall_in)
    assert [word["data"] for word in seen.values["result"]] == want.ravel().tolist()


@pytest.mark.long
@pytest.mark.parametrize("forces", [False, True])
def test_every_probe_shows_the_models_stage(forces, tmp_path: Path):
    """Of frames that are alone in the core."""
    design = learned_design(2, 3, (2, 1), 9, taxel_forces=forces)
    for codes in codes_of(design, 6, 11)[2:5, None]:
        model = design.model(codes)
        found = simulate_core(design, codes, "icarus", build_dir=tmp_path, probes=True)
        assert (found.words == model.words).all()
        assert list(found.probes) == [stage for stage in Stage if stage in model.stages and stage != Stage.WORDS]
        for stage, words in found.probes.items():
            np.testing.assert_array_equal(words, model.stages[Stage(stage)].reshape(1, -1), stage)


def test_choices_are_the_cores_with_other_lanes():
    core = LearnedParallel(learned_design(2, 4, (3, 2)))
    found = list(core.choices())
    assert [choice.lanes for choice in found] == [4, 8] == list(core.lane_choices)
    for choice in found:
        alone = LearnedParallel(replace(choice.design))
        assert (choice.latency, choice.initiation_interval) == (alone.latency, alone.initiation_interval)


@pytest.mark.parametrize(
    ("seed", "name", "single", "double"), [(2, "h1", 119, 117), *long((2, "h2", 119, 117), (9, "p0", 145, 131))]
)
def test_a_second_bank_saves_cycles(seed, name, single, double, monkeypatch):
    """A frame every so many cycles."""
    design = random_design(seed)
    assert LearnedParallel(design).initiation_interval == double

    def with_one_bank(design):
        found = plan(design)
        sources = (replace(source, banks=1) if source.name == name else source for source in found.sources)
        return replace(found, sources=tuple(sources))

    monkeypatch.setattr(timeline, "plan", with_one_bank)
    assert LearnedParallel(design).initiation_interval == single


@pytest.mark.parametrize("forces", [*long(True), False])
def test_frames_that_a_core_takes_while_its_output_sleeps(forces):
    """As many as hold a place or a bank, and one whose facts wait for those of another; then taxels have to wait."""
    design = learned_design(2, 2, (1, 1), 1, taxel_forces=forces)
    core, codes, taken = LearnedCore(design), codes_of(design, 12, 1).ravel().tolist(), []

    async def bench(ctx):
        ctx.set(core.taxel.valid, 1)
        for _ in range(900):
            ctx.set(core.taxel.payload, codes[len(taken)])
            *_, ready = await ctx.tick().sample(core.taxel.ready)
            taken.extend([ready] * ready)

    simulate(core, bench)
    assert len(taken) // design.sensor.taxels == core.fact_depth + 1 == FRAMES + 3


def test_a_wrong_bit_is_noticed():
    design = learned_design(2, 2, (3, 2), 1)
    codes = codes_of(design, 4, seed=1)[3:]
    other = replace(design, weights=replace(design.weights, read2=-design.weights.read2))
    words, *_ = stream(design, codes)
    assert (words != other.model.words(codes)).any()
