"""Sums of products of every lane, when they are stated to be there."""

from __future__ import annotations

import random

import pytest
from amaranth.sim import Simulator

from tfra.hdl.serial.isa import MAC_DELAY
from tfra.hdl.serial.lanes import Lanes
from tfra.hdl.serial.sizes import Sizes

SIZES = Sizes(24, 8, 12, 16, 3, 24, 16, 16, 16, 8, 16)


@pytest.mark.parametrize("quads", [1, 2, 5])
def test_two_groups_back_to_back(quads):
    rng = random.Random(quads)
    groups = 2
    operands = [rng.randrange(-1 << 11, 1 << 11) for _ in range(quads)]
    rows = [[rng.randrange(-1 << 7, 1 << 7) for _ in range(SIZES.lanes)] for _ in range(groups * quads)]
    dut = Lanes(SIZES, quads, quads, len(rows), "portable")
    interval = max(quads, SIZES.lanes)

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
        ready = [group * interval + quads + MAC_DELAY - 1 for group in range(groups)]
        for cycle in range(ready[-1] + SIZES.lanes):
            ctx.set(dut.start, cycle % interval == 0 and cycle < groups * interval)
            reading = any(first <= cycle < first + SIZES.lanes for first in ready)
            ctx.set(dut.next, reading)
            if reading:
                found.append(ctx.get(dut.sum))
            await ctx.tick()
        products = [
            [sum(a * row[lane] for a, row in zip(operands, rows[quads * g :], strict=False)) for lane in range(3)]
            for g in range(groups)
        ]
        assert found == [value for group in products for value in group]

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
