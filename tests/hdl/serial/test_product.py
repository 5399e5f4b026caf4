"""Products of any word lengths are exact."""

from __future__ import annotations

import random

import pytest
from amaranth.sim import Simulator

from tfra.hdl.serial.product import DELAY, Product


@pytest.mark.parametrize(("a_bits", "b_bits"), [(18, 18), (34, 21), (33, 19), (16, 16), (24, 24), (10, 12)])
def test_products_are_exact(a_bits, b_bits):
    dut, rng = Product(a_bits, b_bits, a_bits + b_bits), random.Random(a_bits * b_bits)
    ends = [(a, b) for a in (-1 << (a_bits - 1), (1 << (a_bits - 1)) - 1) for b in (-1 << (b_bits - 1), -1, 0)]
    pairs = ends + [(rng.randrange(-1 << a_bits, 1 << a_bits) >> 1, rng.randrange(-1 << b_bits, 1 << b_bits) >> 1)
                    for _ in range(100)]

    async def bench(ctx):
        for number, (a, b) in enumerate([*pairs, *[(0, 0)] * (DELAY - 1)]):
            ctx.set(dut.a, a)
            ctx.set(dut.b, b)
            await ctx.tick()
            if number >= DELAY - 1:
                want = pairs[number - DELAY + 1]
                assert ctx.get(dut.o) == want[0] * want[1]

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
