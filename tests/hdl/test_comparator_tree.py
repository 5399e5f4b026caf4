"""The tree finds the minimum and the first that holds it, a set every cycle."""

from __future__ import annotations

import random

import pytest
from amaranth.sim import Simulator

from tfra.hdl.comparator_tree import ComparatorTree


def winners(tree, sets):
    """(least, place) of every set, sent back to back, read ``latency`` cycles later."""
    seen = []

    async def bench(ctx):
        for cycle in range(len(sets) + tree.latency):
            for key, value in zip(tree.keys, sets[min(cycle, len(sets) - 1)], strict=True):
                ctx.set(key, value)
            if cycle >= tree.latency:
                seen.append((ctx.get(tree.least), ctx.get(tree.place)))
            if tree.latency:
                await ctx.tick()

    simulator = Simulator(tree)
    simulator.add_clock(1e-6, if_exists=True)  # a single key meets no register
    simulator.add_testbench(bench)
    simulator.run()
    return seen


@pytest.mark.parametrize("ways", [1, 2, 3, 5, 8, 13])
@pytest.mark.parametrize("bits", [1, 9])
def test_first_of_the_smallest_wins(ways, bits):
    rng = random.Random(f"{ways} {bits}")
    top = (1 << bits) - 1
    sets = [[rng.choice([0, 1, top, rng.randint(0, top)]) for _ in range(ways)] for _ in range(80)]
    sets += [[0] * ways, [top] * ways, list(range(ways)) if ways <= top else [1] * ways]
    assert winners(ComparatorTree(ways, bits), sets) == [(min(keys), keys.index(min(keys))) for keys in sets]


@pytest.mark.parametrize(("ways", "latency"), [(1, 0), (2, 1), (3, 2), (26, 5), (101, 7)])
def test_latency_is_the_number_of_levels(ways, latency):
    assert ComparatorTree(ways, 4).latency == latency


def test_a_corrupted_key_is_seen():
    sets = [[5, 3, 4], [2, 9, 1]]
    assert winners(ComparatorTree(3, 4), [[5, 3, 2], sets[1]])[0] != (3, 1)
