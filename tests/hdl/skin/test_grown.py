"""Grown: what the model takes about a region, and the region's bitmap is empty afterwards."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.skin.memories import Bitmap, bits_of, played, serve, until, words_of
from tests.hdl.skin.skins import skin_of
from tfra.hdl.skin.grown import Grown
from tfra.model.skin.regions import grown


def taken_of(region, before, gap):
    """What is taken then, what is left of the region, and cycles."""
    shape = region.shape
    block = Grown(skin_of(*shape))
    marked, taken = Bitmap(words_of(region), block.region), Bitmap(words_of(before), block.taken)
    rows, cycles = np.flatnonzero(region.any(axis=1)), 0

    async def bench(ctx):
        nonlocal cycles
        ctx.set(block.first, int(rows[0]))
        ctx.set(block.last, int(rows[-1]))
        ctx.set(block.gap, gap)
        ctx.set(block.start, 1)
        await ctx.tick()
        ctx.set(block.start, 0)
        cycles = await until(ctx, block.done)

    async def memories(ctx):
        await serve(ctx, [marked, taken])

    played(block, bench, memories)
    return bits_of(taken.rows, shape[1]), marked.rows, cycles


@settings(max_examples=20)
@given(shape=st.tuples(st.integers(2, 9), st.integers(3, 9)), gap=st.integers(0, 4), seed=st.integers(0, 999))
def test_what_is_taken_is_that_of_the_model(shape, gap, seed):
    rng = np.random.default_rng(seed)
    before, region = rng.random((2, *shape)) < rng.uniform(0.02, 0.4, (2, 1, 1))
    first, last = sorted(rng.integers(0, shape[0], 2))
    region[:first] = region[last + 1 :] = False
    region[first : last + 1, rng.integers(shape[1])] = True
    taken, left, cycles = taken_of(region, before, gap)
    assert (taken == (before | grown(region[None], gap)[0])).all()
    assert not any(left)
    assert cycles <= (last - first + 1) * (4 + 3 * gap) + 6


@pytest.mark.parametrize("gap", [0, 4])
def test_a_corner_stays_inside_the_array(gap):
    region = np.zeros((6, 7), dtype=np.bool_)
    region[5, 6] = True
    taken, *_ = taken_of(region, np.zeros_like(region), gap)
    assert (taken == grown(region[None], gap)[0]).all()
