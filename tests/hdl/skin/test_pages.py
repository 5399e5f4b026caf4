"""Pages: words of a frame while the next one is written."""

import numpy as np

from tests.hdl.skin.memories import played
from tests.hdl.skin.skins import skin_of
from tfra.hdl.skin.pages import Pages


def test_a_frame_stays_while_the_next_one_is_written():
    skin = skin_of(5, 6)
    block = Pages(skin, 8)
    frames = np.random.default_rng(1).integers(0, 256, (5, 5, 6))
    got = []

    async def bench(ctx):
        for number, frame in enumerate(frames):
            ctx.set(block.page, (number + 1) % 2)
            for (row, column), word in np.ndenumerate(frame):
                ctx.set(block.i.valid, 1)
                ctx.set(block.i.payload, int(word))
                ctx.set(block.place, {"row": 4 - row, "column": 5 - column})
                ctx.set(block.read, column != 2)  # then the word before stays
                await ctx.tick()
                got.append(ctx.get(block.o))

    played(block, bench)
    turned = frames[:, ::-1, ::-1].copy()
    turned[:, :, 2] = turned[:, :, 1]
    assert got[30:] == turned[:-1].ravel().tolist()
