"""Regions: the taxels that the model connects to a peak, their extent, and whether others cut them off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.hdl.skin.memories import Bitmap, bits_of, played, serve, until, words_of
from tests.hdl.skin.skins import skin_of
from tfra.hdl.skin.regions import Regions
from tfra.model.skin.regions import regions, spans
from tfra.sim.harness import plain

HEIGHTS = st.sampled_from((0, 49, 50, 50, 51, 99, 100, 100))


def found_of(skin, grids, taken, places):
    """For each grid of heights, the region's record and bitmap, and cycles; the last one with the same block."""
    block, shape, found = Regions(skin), grids.shape[1:], []

    for grid, blocked, place in zip(grids, taken, places, strict=True):
        marked = Bitmap([0] * shape[0], block.region)
        cycles = 0

        async def bench(ctx, grid=grid, place=place):
            nonlocal cycles
            ctx.set(block.peak, {"height": int(grid[place]), "place": {"row": place[0], "column": place[1]}})
            ctx.set(block.start, 1)
            await ctx.tick()
            ctx.set(block.start, 0)
            cycles = await until(ctx, block.done)
            found.append(plain(ctx.get(block.o)))

        async def memories(ctx, grid=grid, blocked=blocked, marked=marked):
            await serve(ctx, [marked, Bitmap(words_of(blocked), block.taken)], (block, grid))

        played(block, bench, memories)
        found[-1] = (found[-1], bits_of(marked.rows, shape[1]), cycles)
    return found


def check(grids, taken, places):
    high = 2 * grids >= np.array([grid[place] for grid, place in zip(grids, places, strict=True)])[:, None, None]
    flat = np.array([place[0] * grids.shape[2] + place[1] for place in places])
    want, touching = regions(high, ~taken, flat)
    rows, columns = spans(want)
    for number, (record, marked, cycles) in enumerate(found_of(skin_of(*grids.shape[1:]), grids, taken, places)):
        assert (marked == want[number]).all()
        assert record["taxels"] == want[number].sum()
        assert record["touching"] == touching[number]
        for name, span in (("rows", rows), ("columns", columns)):
            assert record[name] == {key: getattr(span, key)[number] for key in ("first", "last", "total")}
        assert cycles <= 9 * record["taxels"] + 12


@settings(max_examples=20)
@given(
    grid=st.tuples(st.integers(2, 7), st.integers(3, 7)).flatmap(lambda s: arrays(np.int64, s, elements=HEIGHTS)),
    seed=st.integers(0, 999),
)
def test_regions_are_those_of_the_model(grid, seed):
    rng = np.random.default_rng(seed)
    taken = rng.random(grid.shape) < 0.15
    place = tuple(int(rng.integers(size)) for size in grid.shape)
    grid[place], taken[place] = 100, False
    check(grid[None], taken[None], [place])


@pytest.mark.parametrize("place", [(0, 0), (0, 6), (5, 0), (5, 6), (2, 3)])
def test_the_whole_array_and_corners(place):
    grid = np.full((6, 7), 100)
    check(grid[None], np.zeros((1, 6, 7), dtype=np.bool_), [place])


def test_a_winding_region_is_followed_to_its_end():
    grid = np.zeros((7, 9), dtype=np.int64)
    grid[::2] = 60
    grid[1::4, -1] = grid[3::4, 0] = 60
    grid[0, 0] = 100
    check(grid[None], np.zeros((1, 7, 9), dtype=np.bool_), [(0, 0)])
