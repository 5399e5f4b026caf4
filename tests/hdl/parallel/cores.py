"""Whole cores of either estimator in Amaranth's simulator: words, cycles and resets."""

import random
from collections.abc import Sequence
from typing import Any

import numpy as np
from amaranth import ResetInserter, Signal

from tests.hdl.parallel.designs import simulate
from tfra.hdl.cores import microarchitecture
from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.sim.harness import run


def stream(design: Design, codes: Ints, **stalls: Any) -> tuple[Ints, Ints, Ints, Ints, Ints]:
    """Result words ``(n, words)``, the model's, last marks, and the cycles of taxels and of result words."""
    want = design.model(codes).words
    core = microarchitecture(design).build()
    seen = run(core, {"taxel": codes.ravel().tolist()}, {"result": want.size}, **stalls)
    words = np.array([word["data"] for word in seen.values["result"]]).reshape(want.shape)
    last = np.array([word["last"] for word in seen.values["result"]]).reshape(want.shape)
    taken = np.array(seen.cycles["taxel"]).reshape(len(codes), -1)
    return words, want, last, taken, np.array(seen.cycles["result"]).reshape(want.shape)


def check_words(design: Design, codes: Ints, **stalls: Any) -> None:
    """Every word equals the model's; the last of each frame, and no other, is marked."""
    words, want, last, *_ = stream(design, codes, **stalls)
    names = [field.name for field in design.layout for _ in range(field.count)]
    bad = np.argwhere(words != want)
    assert not len(bad), f"frame {bad[0][0]}, {names[bad[0][1]]}, word {bad[0][1]}"
    assert last[:, -1].all()
    assert last.sum() == len(want)


def check_timing(design: Design, codes: Ints) -> None:
    """Every taxel and every word of frames back to back comes in the cycle that the timeline says."""
    words, want, _, taken, cycles = stream(design, codes)
    frames = microarchitecture(design).timeline(len(codes)).frames
    assert (words == want).all()
    taken = taken[:, -1]
    assert (taken - taken[0]).tolist() == [frame.taxel for frame in frames]
    assert (cycles - taken[0]).tolist() == [frame.words for frame in frames]


def check_single_frame(design: Design, codes: Ints) -> None:
    """A frame in an idle core takes the stated latency."""
    words, want, _, taken, cycles = stream(design, codes)
    timing = microarchitecture(design)
    assert (words == want).all()
    assert taken[0, -1] - taken[0, 0] == timing.intake
    assert cycles[0, 0] - taken[0, -1] == timing.latency
    assert cycles[0, -1] - taken[0, -1] == timing.frame_latency


def sleepy(rng: random.Random) -> Any:
    """Asleep for longer than frames take, then awake for a while, so that every place in the core fills up."""
    while True:
        yield from [True] * rng.randrange(2000)
        yield from [False] * rng.randrange(1, 400)


def check_resets(design: Design, codes: Ints, interrupted: Sequence[int], held: int, rng: random.Random) -> None:
    """After resets in these cycles of random frames, ``held`` for so long, the frames of the model come."""
    timing, core, reset = microarchitecture(design), microarchitecture(design).build(), Signal()
    want: Any = design.model(codes).words.ravel().tolist()
    words: list[int] = []

    async def bench(ctx: Any) -> None:
        for cycles in interrupted:
            ctx.set(core.taxel.valid, 1)
            for _ in range(cycles):
                ctx.set(core.taxel.payload, rng.randrange(-30_000, 30_000))
                ctx.set(core.result.ready, rng.random() < 0.7)
                await ctx.tick()
            ctx.set(core.taxel.valid, 0)
            ctx.set(reset, 1)
            for _ in range(held):
                await ctx.tick()
            ctx.set(reset, 0)
        ctx.set(core.result.ready, 1)
        taxels = codes.ravel().tolist()
        for _ in range(codes[0].size * 3 + timing.frame_latency + 8 * timing.initiation_interval):
            ctx.set(core.taxel.valid, bool(taxels))
            ctx.set(core.taxel.payload, taxels[0] if taxels else 0)
            _, _, taken, valid, word = await ctx.tick().sample(core.taxel.ready, core.result.valid, core.result.payload)
            if taken and taxels:
                taxels.pop(0)
            if valid:
                words.append(word["data"])

    simulate(ResetInserter(reset)(core), bench)
    assert words == want, f"after resets at {interrupted}"
