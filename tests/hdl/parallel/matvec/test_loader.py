"""Every coefficient is written once, where its lane looks for it, however the stream stalls."""

import random
from dataclasses import replace

import pytest

from tests.hdl.parallel.designs import make, simulate
from tfra.hdl.parallel.matvec.images import depth
from tfra.hdl.parallel.matvec.loader import Loader

DESIGN = replace(make(2, 2), images="load")


def load(share: float, seed: int) -> tuple[list[tuple[int, int, int]], list[tuple[bool, bool, int]]]:
    """Writes as (lanes, address, data), and by cycle: loading, writing, coefficients taken; valid in a ``share``."""
    rng, loader, count = random.Random(seed), Loader(DESIGN), 4 * depth(DESIGN)
    writes, states = [], []

    async def bench(ctx):
        taken = 0
        for _ in range(int(count / share) + 200):
            valid = taken < count and rng.random() < share
            ctx.set(loader.load.valid, valid)
            ctx.set(loader.load.payload, taken - 20 if valid else rng.randrange(-100, 100))
            outputs = loader.load.ready, loader.write, loader.address, loader.data, loader.loading, loader.writing
            _, _, ready, write, address, data, loading, writing = await ctx.tick().sample(*outputs)
            if write:
                writes.append((write, address, data))
            states.append((bool(loading), bool(writing), taken))
            taken += bool(valid and ready)

    simulate(loader, bench)
    return writes, states


@pytest.mark.parametrize("share", [1.0, 0.5, 0.1])
def test_every_coefficient_once_in_its_place(share: float) -> None:
    words = depth(DESIGN)
    writes, states = load(share, seed=3)
    assert writes == [(1 << lane, place, lane * words + place - 20) for lane in range(4) for place in range(words)]
    for loading, writing, taken in states:
        assert loading == (taken < 4 * words)
        assert writing >= loading
    assert not states[-1][1]
