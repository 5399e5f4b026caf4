"""Real cores take a coefficient in every cycle after a reset, so a word of LOAD_DATA never waits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from amaranth.sim import Simulator

from tests.codegen.test_generate import DESIGNS
from tfra.hdl.cores import microarchitecture

LOADED = {"serial": DESIGNS["serial"], "parallel": replace(DESIGNS["loaded"], name="core")}


@pytest.mark.parametrize("kind", LOADED)
def test_ready_until_the_last_word(kind: str) -> None:
    made = microarchitecture(LOADED[kind])
    core, words = made.build(), made.loaded
    assert words is not None
    ready = []

    async def drive(ctx: Any) -> None:
        ctx.set(core.load.valid, 1)
        for word in words.tolist():
            ctx.set(core.load.payload, word)
            ready.append(ctx.get(core.load.ready))
            await ctx.tick()
        ready.append(ctx.get(core.load.ready))

    simulator = Simulator(core)
    simulator.add_clock(1e-6)
    simulator.add_testbench(drive)
    simulator.run()
    assert ready == [1] * words.size + [0]
