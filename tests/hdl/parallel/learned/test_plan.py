"""What the plan of products keeps places for, and what each of them is worth."""

from dataclasses import replace

import pytest

from tests.hdl.parallel.designs import simulate
from tests.hdl.parallel.learned.designs import random_design
from tests.model.fixed.learned.cases import codes_of, learned_design
from tfra.hdl.parallel.learned import timeline
from tfra.hdl.parallel.learned.core import LearnedCore
from tfra.hdl.parallel.learned.parallel import LearnedParallel
from tfra.hdl.parallel.learned.plan import FRAMES, plan


@pytest.mark.parametrize(
    ("seed", "name", "single", "double"), [(2, "h1", 119, 117), (2, "h2", 119, 117), (9, "p0", 145, 131)]
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


@pytest.mark.parametrize("forces", [True, False])
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
