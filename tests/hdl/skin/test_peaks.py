"""Peaks: those of the model that are not below the floor, and the highest of each frame."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.hdl.skin.memories import played
from tests.hdl.skin.skins import skin_of, small_window
from tfra.hdl.skin.peaks import Peaks
from tfra.model.skin.peaks import peaks
from tfra.model.skin.smoothing import GAIN
from tfra.sim.harness import plain

FLOOR = 3
HEIGHTS = st.sampled_from((0, 1, FLOOR * GAIN - 1, FLOOR * GAIN, 200, 201, 1 << 15))


def seen_of(block, frames, gaps):
    """Peaks, and pairs of the highest and the number of peaks before each end, for heights with cycles between them."""
    found, ends, cycles = [], [], []

    async def bench(ctx):
        for height, gap in zip(frames.ravel().tolist(), gaps, strict=True):
            ctx.set(block.i.valid, 0)
            await ctx.tick().repeat(gap) if gap else None
            ctx.set(block.i.payload, height)
            ctx.set(block.i.valid, 1)
            await ctx.tick()
        ctx.set(block.i.valid, 0)
        await ctx.tick().repeat(block.latency + 2)

    async def watch(ctx):
        while True:
            _, _, valid, peak, end, highest = await ctx.tick().sample(
                block.o.valid, block.o.payload, block.ends, block.highest
            )
            cycles.append(end)
            if valid:
                found.append(plain(peak))
            if end:
                ends.append((highest, len(found)))

    played(block, bench, watch)
    return found, ends, cycles


def expected(frames):
    there = peaks(frames) & (frames >= FLOOR * GAIN)
    found = [
        {"height": int(frames[frame, row, column]), "place": {"row": int(row), "column": int(column)}}
        for frame, row, column in np.argwhere(there)
    ]
    return found, list(zip(frames.max(axis=(1, 2)), np.cumsum(there.sum(axis=(1, 2))), strict=True))


@settings(max_examples=15)
@given(
    frames=st.tuples(st.integers(2, 6), st.integers(2, 6)).flatmap(
        lambda shape: arrays(np.int64, (3, *shape), elements=HEIGHTS)
    ),
    most=st.integers(0, 2),
    seed=st.integers(0, 99),
)
def test_peaks_are_those_of_the_model(frames, most, seed):
    block = Peaks(skin_of(*frames.shape[1:], small_window(2, 2, threshold=FLOOR)))
    gaps = np.random.default_rng(seed).integers(0, most + 1, frames.size)
    found, ends, _ = seen_of(block, frames, gaps)
    assert (found, ends) == expected(frames)


def test_the_end_comes_after_the_stated_cycles():
    block, frames = Peaks(skin_of(4, 5)), np.ones((2, 4, 5), dtype=np.int64)
    *_, cycles = seen_of(block, frames, [0] * frames.size)
    assert np.flatnonzero(cycles).tolist() == [frames.size // 2 - 1 + block.latency, frames.size - 1 + block.latency]
