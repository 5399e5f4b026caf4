"""Candidates: every search finds the highest peak that is free and high enough, and keeps the others of these."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.hdl.skin.memories import Bitmap, played, serve, until, words_of
from tests.hdl.skin.skins import skin_of
from tfra.hdl.skin.candidates import Candidates
from tfra.hdl.skin.payloads import most_peaks
from tfra.sim.harness import plain

SHAPE = (6, 8)
SKIN = skin_of(*SHAPE)


def peaks_of(rng, count):
    """Peaks of a frame, row by row; some are equally high."""
    places = np.sort(rng.choice(SHAPE[0] * SHAPE[1], count, replace=False))
    heights = rng.integers(1, 300, count) * rng.choice([1, 1, 20], count)
    return [
        {"height": int(height), "place": {"row": int(place // SHAPE[1]), "column": int(place % SHAPE[1])}}
        for height, place in zip(heights, places, strict=True)
    ]


def expected(peaks, threshold, maps):
    """The number of peaks and the best of each search."""
    highest, found = max((peak["height"] for peak in peaks), default=0), []
    for taken in maps:
        peaks = [
            peak
            for peak in peaks
            if 256 * peak["height"] >= highest * threshold and not taken[peak["place"]["row"], peak["place"]["column"]]
        ]
        found.append((len(peaks), max(peaks, key=lambda peak: peak["height"], default=None)))
    return found


@settings(max_examples=15)
@given(seed=st.integers(0, 9999), threshold=st.integers(1, 256), density=st.sampled_from((0.0, 0.2, 0.6)))
def test_searches_are_those_of_plain_lists(seed, threshold, density):
    rng, block = np.random.default_rng(seed), Candidates(SKIN)
    frames = [peaks_of(rng, int(rng.integers(0, most_peaks(SKIN) + 1))) for _ in range(3)] + [[]]
    maps = [np.logical_or.accumulate(rng.random((3, *SHAPE)) < density) for _ in frames]
    rows, found = Bitmap([0] * SHAPE[0], block.taken), [[] for _ in frames]

    async def send(ctx, peaks):
        for peak in peaks:
            ctx.set(block.i.valid, 1)
            ctx.set(block.i.payload, peak)
            await ctx.tick()
        ctx.set(block.i.valid, 0)
        ctx.set(block.highest, max((peak["height"] for peak in peaks), default=0))
        ctx.set(block.ends, 1)
        await ctx.tick()
        ctx.set(block.ends, 0)

    async def bench(ctx):
        ctx.set(block.threshold, threshold)
        await send(ctx, frames[0])
        for number, own in enumerate(maps):
            assert ctx.get(block.waiting)
            ctx.set(block.begin, 1)
            await ctx.tick()
            ctx.set(block.begin, 0)
            while not ctx.get(block.settled):
                await ctx.tick()
            if number + 1 < len(frames):
                await send(ctx, frames[number + 1])  # into the other page
            for taken in own:
                rows.rows[:] = words_of(taken)
                ctx.set(block.search, 1)
                await ctx.tick()
                ctx.set(block.search, 0)
                await until(ctx, block.searched)
                left = ctx.get(block.left)
                found[number].append((left, plain(ctx.get(block.best)) if left else None))

    async def memories(ctx):
        await serve(ctx, [rows])

    played(block, bench, memories)
    for got, peaks, own in zip(found, frames, maps, strict=True):
        assert got == expected(peaks, threshold, own)
