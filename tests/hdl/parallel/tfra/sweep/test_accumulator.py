"""Accumulator against sums in a list: additions back to back to few addresses, drains, resets, at every distance."""

import random
from dataclasses import dataclass

import pytest
from amaranth import ResetInserter, Signal, unsigned
from amaranth.lib import data

from tests.hdl.parallel.designs import simulate
from tfra.hdl.lib.pipeline import READ
from tfra.hdl.parallel.tfra.sweep.accumulator import DRAIN, Accumulator

VALUE = data.StructLayout({"a": unsigned(6), "b": unsigned(9)})
TOTAL = data.StructLayout({"a": unsigned(14), "b": unsigned(16)})
SIZES = [(entries, banks) for entries in (1, 2, 3, 8, 13) for banks in (1, 2)]
REACH = 6
"""Cycles from an addition to a later one: beyond the last that takes its sum from a register."""


@dataclass
class Round:
    """Additions ``(address, a, b)`` or None, one a cycle, and the cycles to wait from the last one to the drain."""

    additions: list[tuple[int, int, int] | None]
    wait: int = 0


def expected(entries, rounds):
    """Sums in a list, as anyone would make them."""
    found = []
    for one in rounds:
        sums = [(0, 0)] * entries
        for at, a, b in filter(None, one.additions):
            sums[at] = (sums[at][0] + a, sums[at][1] + b)
        found.append(sums)
    return found


def run(entries, banks, rounds, reset_at=()):
    """Sums of each round; every one begins as soon as it may, those numbered in ``reset_at`` end with a reset."""
    dut, reset, depth = Accumulator(VALUE, TOTAL, entries, banks), Signal(), -(-entries // banks)
    drains, rows, reads, cycle = [-DRAIN], [], [], 0

    async def tick(ctx, addition=None):
        nonlocal cycle
        at, a, b = addition or (0, 63, 511)  # what is not valid must not count
        ctx.set(dut.address, at)
        ctx.set(dut.value, {"a": a, "b": b})
        ctx.set(dut.valid, addition is not None)
        if ctx.get(dut.draining):
            reads.append(cycle)
        if cycle - READ in reads:
            rows.append([(ctx.get(row.a), ctx.get(row.b)) for row in dut.rows])
        await ctx.tick()
        cycle += 1

    async def drive(ctx):
        for number, one in enumerate(rounds):
            for _ in range(depth + 1):
                await tick(ctx)
            for addition in [*one.additions, *[None] * one.wait]:
                await tick(ctx, addition)
            signal = reset if number in reset_at else dut.drain
            drains.append(cycle + 1 - DRAIN if number in reset_at else cycle)
            ctx.set(signal, 1)
            await tick(ctx)
            ctx.set(signal, 0)
            for _ in range(0 if number in reset_at else DRAIN - 1):
                await tick(ctx)
        for _ in range(depth + READ):
            await tick(ctx)

    simulate(ResetInserter(reset)(dut), drive)
    assert reads == [drain + DRAIN + row for drain in drains for row in range(depth)]
    drained = [[word for row in rows[at : at + depth] for word in row] for at in range(depth, len(rows), depth)]
    return [sums[:entries] for number, sums in enumerate(drained) if number not in reset_at]


def anything(entries, seed, idle=0.2):
    """Rounds with many additions to the same few addresses."""
    rng, rounds = random.Random(seed), []
    for _ in range(6):
        few = [rng.randrange(entries) for _ in range(rng.randint(1, 3))]
        additions = [
            None if rng.random() < idle else (rng.choice(few), rng.randrange(64), rng.randrange(512))
            for _ in range(rng.randint(0, 40))
        ]
        rounds.append(Round(additions, rng.choice([0, 0, 3])))
    return rounds


@pytest.mark.parametrize(("entries", "banks"), SIZES)
def test_sums_of_random_additions(entries, banks):
    for seed in range(3):
        rounds = anything(entries, seed, idle=0.3 * (seed % 3))
        assert run(entries, banks, rounds) == expected(entries, rounds), f"seed {seed}"


@pytest.mark.parametrize("banks", [1, 2])
def test_two_and_three_additions_at_every_distance(banks):
    """The latest of several sums in registers is the one that counts; in between are additions to another address."""
    rounds = []
    for first in range(1, REACH + 1):
        for second in range(1, REACH + 1):
            for other in (None, (1, 1, 1), (2, 1, 1)):
                additions = [other] * (first + second + 1)
                additions[0], additions[first], additions[-1] = (0, 1, 10), (0, 20, 200), (0, 40, 400)
                rounds.append(Round(additions))
    assert run(3, banks, rounds) == expected(3, rounds)


@pytest.mark.parametrize("banks", [1, 2])
def test_the_longest_sums(banks):
    """All bits of both fields: 256 of the largest values would be one too many for ``a``, 128 for ``b``."""
    rounds = [Round([(1, 63, 511)] * 128)]
    assert run(2, banks, rounds) == [[(0, 0), (128 * 63, 128 * 511)]]


@pytest.mark.parametrize(("entries", "banks"), SIZES)
def test_every_address_at_both_ends_of_a_drain(entries, banks):
    """Nothing is left of the round before, where it is added first, nor lost, where it was added last."""
    rounds = [Round([(at, 1, 10 + at), (at, 2, 20)]) for _ in range(2) for at in range(entries)]
    assert run(entries, banks, rounds) == expected(entries, rounds)


@pytest.mark.parametrize("banks", [1, 2])
def test_a_reset_clears_all(banks):
    """In the middle of additions, which leave words in every stage and in the memory."""
    rounds = [Round([(at % 5, 60, 500) for at in range(12)]), *anything(5, 9)]
    kept = [number for number in range(len(rounds)) if number not in (0, 3)]
    assert run(5, banks, rounds, reset_at=(0, 3)) == expected(5, [rounds[number] for number in kept])


def test_a_wrong_value_is_noticed():
    rounds = anything(8, 4)
    wanted = expected(8, rounds)
    number = next(at for at, one in enumerate(rounds[0].additions) if one)
    at, a, b = rounds[0].additions[number]
    rounds[0].additions[number] = (at, a ^ 4, b)
    assert run(8, 1, rounds) != wanted
