"""Real cores take a coefficient in every cycle after a reset, so a word of LOAD_DATA never waits."""

from typing import Any

import pytest

from tests.hdl.bus.manager import simulated
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, Architecture, Search
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


@pytest.mark.parametrize("architecture", [SERIAL, Architecture(4)], ids=["serial", "parallel"])
def test_ready_until_the_last_word(architecture: Architecture) -> None:
    sensor = SensorArray(2, 2, 4e-3, 4e-3, 3e-3)
    images = "inline" if architecture is SERIAL else "load"
    design = TfraDesign(sensor, search=Search(3), architecture=architecture, images=images)
    timing = microarchitecture(design)
    core, words = timing.build(), timing.loaded
    assert words is not None
    ready = []

    async def drive(ctx: Any) -> None:
        ctx.set(core.load.valid, 1)
        for word in words.tolist():
            ctx.set(core.load.payload, word)
            ready.append(ctx.get(core.load.ready))
            await ctx.tick()
        ready.append(ctx.get(core.load.ready))

    simulated(core, drive)
    assert ready == [1] * words.size + [0]
