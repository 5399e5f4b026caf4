"""Winner against a search through lists: ties, plateaus, limits of the tolerance, single candidates and pairs."""

import random
from dataclasses import dataclass

import pytest

from tests.hdl.parallel.designs import make, simulate
from tfra.hdl.parallel.tfra.sweep.sums import at_once
from tfra.hdl.parallel.tfra.sweep.terms import measured_sum, unit_shift
from tfra.hdl.parallel.tfra.sweep.winner import Winner, winner_latency
from tfra.model.fixed.tfra.sweep import tolerance

GAP = 8
"""Cycles between frames; the sums take longer."""


def of(steps, words, slack=0.0):
    return make(2, 3, steps=steps, words=words, tolerance=slack)


DESIGNS = [of(steps, words, slack) for steps in (1, 2, 6, 7) for words in (1, 4) for slack in (0.0, 0.5)]


@dataclass
class Frame:
    """Sums of all candidates, K times the sum of positive stress, and the exponent."""

    z: list[int]
    xy: list[int]
    measured: int
    exponent: int = 0


def expected(design, frame):
    """Look at all candidates, then at those of the plateau: the first of the smallest."""
    limit = min(frame.z) + int(tolerance(design)[frame.exponent])
    distance = [abs(xy - (frame.measured << unit_shift(design))) for xy in frame.xy]
    plateau = [k for k, z in enumerate(frame.z) if z <= limit]
    return min(plateau, key=lambda k: distance[k])


def run(design, frames):
    """The winners, all of which come when stated."""
    dut, ways, found, last_rows = Winner(design), at_once(design), [], []
    cycle = 0

    async def tick(ctx, there=()):
        nonlocal cycle
        ctx.set(dut.valid, sum(1 << way for way in range(len(there))))
        for way, row in enumerate(dut.rows):
            z, xy = there[way] if way < len(there) else (0, 0)  # what is not valid must not win
            ctx.set(row.z, z)
            ctx.set(row.xy, xy)
        if ctx.get(dut.found):
            found.append((cycle, ctx.get(dut.index)))
        await ctx.tick()
        cycle += 1

    async def drive(ctx):
        for frame in frames:
            ctx.set(dut.measured, frame.measured)
            ctx.set(dut.exponent, frame.exponent)
            rows = list(zip(frame.z, frame.xy, strict=True))
            for first in range(0, len(rows), ways):
                await tick(ctx, rows[first : first + ways])
            last_rows.append(cycle - 1)
            for _ in range(GAP):
                await tick(ctx)
        for _ in range(winner_latency(design)):
            await tick(ctx)

    simulate(dut, drive)
    assert [when for when, _ in found] == [last + winner_latency(design) for last in last_rows]
    return [index for _, index in found]


def anything(design, seed, number=30):
    """Sums that differ by little, so that many tie, around any level."""
    rng, frames = random.Random(seed), []
    w, count, shift = design.widths, design.candidates, unit_shift(design)
    for _ in range(number):
        few, measured = rng.choice([1, 2, 5, 1 << 9]), rng.randrange(1 << (measured_sum(design) - 1))
        z, slack = rng.randrange(1 << (w.b_z - 2)), int(tolerance(design)[0])
        frames.append(
            Frame(
                [z + rng.randrange(few) + rng.choice([0, slack]) for _ in range(count)],
                [max(0, (measured << shift) + rng.randrange(-few, few + 1)) for _ in range(count)],
                measured,
                rng.randrange(3),
            )
        )
    return frames


@pytest.mark.parametrize("design", DESIGNS)
def test_equals_a_search(design):
    frames = anything(design, 1)
    assert run(design, frames) == [expected(design, frame) for frame in frames], "seed 1"


@pytest.mark.parametrize("design", DESIGNS)
def test_each_candidate_alone(design):
    """Of the smallest B^z, then of the smallest B^xy where all B^z are equal, first or last of equals or not."""
    count, frames = design.candidates, []
    for k in range(count):
        far = [1 << 20] * count
        frames.append(Frame([*far[:k], 0, *far[k + 1 :]], far, 0, 0))
        frames.append(Frame(far, [*far[:k], 0, *far[k + 1 :]], 0, 0))
        frames.append(Frame(far, [*far[:k], *[3] * (count - k)], 0, 0))
    assert run(design, frames) == [k for k in range(count) for _ in range(3)]


@pytest.mark.parametrize("words", [1, 4])
def test_the_limit_of_the_plateau(words):
    """A candidate at the tolerance is on the plateau, a unit further it is not; a longer exponent doubles that."""
    design = of(6, words, slack=0.5)
    slack = [int(limit) for limit in tolerance(design)]
    assert 0 < slack[0] < slack[1]
    frames = [
        Frame([5 + slack[e] + more, 9 + slack[e], 5, *[1 << 20] * 4], [0, 1, 2, 0, 0, 0, 0], 0, e)
        for e in (0, 1)
        for more in (0, 1)
    ]
    assert run(design, frames) == [0, 2, 0, 2]


def test_a_wrong_bit_is_noticed():
    design = of(7, 4)
    frames = anything(design, 2)
    wanted = [expected(design, frame) for frame in frames]
    worst = next(n for n, frame in enumerate(frames) if frame.z[wanted[n]] < (1 << design.widths.b_z - 1))
    frames[worst].z[wanted[worst]] |= 1 << (design.widths.b_z - 1)
    assert run(design, frames) != wanted
