"""Sums of products of every lane, when they are stated to be there."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from amaranth.sim import Simulator

from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.sizes import Sizes

SIZES = Sizes(24, 8, 12, 16, 3, 24, 16, 16, 16, 8, 16)


def schedule(lengths):
    """First cycles of groups of these lengths that follow each other as soon as their sums can be told apart."""
    starts = [0]
    for length, following in pairwise(lengths):
        starts.append(starts[-1] + length + max(0, SIZES.lanes - following))
    return starts


@pytest.mark.parametrize("lengths", [(1, 1), (2, 2), (5, 5), (5, 2, 3, 2, 5), (1, 7, 1)])
def test_groups_back_to_back(lengths):
    rng = random.Random(sum(lengths))
    operands = [rng.randrange(-1 << 11, 1 << 11) for _ in range(max(lengths))]
    rows = [[rng.randrange(-1 << 7, 1 << 7) for _ in range(SIZES.lanes)] for _ in range(sum(lengths))]
    choices = tuple(dict.fromkeys(lengths))
    dut = Lanes(SIZES, choices, len(operands), len(rows), "portable")
    starts = dict(zip(schedule(lengths), lengths, strict=True))
    firsts = [start + length + MAC_DELAY - 1 for start, length in starts.items()]
    reading = {first + lane for first in firsts for lane in range(SIZES.lanes)}

    async def load(ctx):
        for row in rows:
            ctx.set(dut.word, sum((value % 256) << (8 * lane) for lane, value in enumerate(row)))
            ctx.set(dut.load, 1)
            await ctx.tick()
        ctx.set(dut.load, 0)
        for address, value in enumerate(operands):
            ctx.set(dut.write, 1)
            ctx.set(dut.write_address, address)
            ctx.set(dut.write_data, value)
            await ctx.tick()
        ctx.set(dut.write, 0)
        ctx.set(dut.set_pointer, 1)
        ctx.set(dut.pointer, 0)
        await ctx.tick()
        ctx.set(dut.set_pointer, 0)

    async def bench(ctx):
        await load(ctx)
        found = []
        for cycle in range(max(reading) + 1):
            ctx.set(dut.start, cycle in starts)
            if len(choices) > 1:
                ctx.set(dut.length, choices.index(starts.get(cycle, lengths[0])))
            ctx.set(dut.next, cycle in reading)
            if cycle in reading:
                found.append(ctx.get(dut.sum))
            await ctx.tick()
        begin, want = 0, []
        for length in lengths:
            products = [[a * b for b in row] for a, row in zip(operands, rows[begin : begin + length], strict=False)]
            want += [sum(column) for column in zip(*products, strict=True)]
            begin += length
        assert found == want

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
