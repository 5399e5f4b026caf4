"""The last stage of output frames alone."""

import random
from typing import Any

import pytest

from tests.hdl.bus.manager import simulated
from tfra.hdl.ip.output_stage import CUT, OutputStage


@pytest.mark.parametrize("seed", range(4))
def test_output_stage_ends_every_frame_that_a_reset_cuts(seed: int) -> None:
    """What leaves: complete frames, or beginnings of frames and a beat that says so; nothing offered is withdrawn."""
    rng, stage = random.Random(seed), OutputStage()
    sent: list[list[int]] = []
    back: list[tuple[list[int], int]] = []
    ended: list[int] = []

    async def source(ctx: Any) -> None:
        for number in range(60):
            sent.append([number << 8 | word for word in range(rng.randint(3, 6))])
            for word in sent[-1]:
                ctx.set(stage.i.valid, 1)
                ctx.set(stage.i.payload, {"data": word, "last": word == sent[-1][-1], "started": number})
                ready = restart = False
                while not ready and not restart:
                    restart = rng.random() < 0.05
                    ctx.set(stage.restart, restart)
                    _, _, ready = await ctx.tick().sample(stage.i.ready)
                    ctx.set(stage.restart, 0)
                ctx.set(stage.i.valid, 0)
                if restart:
                    break
        await ctx.tick().repeat(50)

    async def sink(ctx: Any) -> None:
        words: list[int] = []
        offered = None
        while True:
            ready = rng.random() < 0.5
            ctx.set(stage.o.ready, ready)
            _, _, valid, p, end, started = await ctx.tick().sample(
                stage.o.valid, stage.o.payload, stage.ended, stage.started
            )
            assert offered in (None, (valid, p.data, p.user, p.last)), "withdrawn or changed"
            offered = (valid, p.data, p.user, p.last) if valid and not ready else None
            ended.extend([started] * end)
            if valid and ready:
                words += [] if p.user else [p.data]
                assert not p.user or p.data == CUT
                if p.last:
                    back.append((words, p.user))
                    words = []

    simulated(stage, source, background=[sink])
    complete = [words for words, cut in back if not cut]
    assert all(words in sent for words in complete)
    assert ended == [words[0] >> 8 for words in complete]
    cuts = [words for words, cut in back if cut]
    assert cuts
    assert all(words and any(each[: len(words)] == words for each in sent) for words in cuts)
