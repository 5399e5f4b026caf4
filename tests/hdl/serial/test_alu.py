"""The ALU's results are those of integers."""

import random

import pytest

from tests.hdl.bus.manager import simulated
from tfra.hdl.serial.alu import ADDS, FINE, Alu
from tfra.hdl.serial.isa import Op
from tfra.hdl.serial.sizes import Sizes

SIZES = Sizes(24, 8, 12, 16, 2, 24, 16, 16, 16, 8, 16)
WORD, OPERAND, RESULT = SIZES.word, SIZES.operand, SIZES.result


def wrapped(value):
    return (value + (1 << (WORD - 1))) % (1 << WORD) - (1 << (WORD - 1))


WANT = {
    Op.ADD: lambda left, source: wrapped(left + source),
    Op.OR: lambda left, source: left | (~source if source < 0 else source),
    Op.AND: lambda left, source: left & source,
    Op.LIMIT: lambda left, source: sorted((-1 << (RESULT - 1), source, (1 << (RESULT - 1)) - 1))[1],
    Op.FIT: lambda left, source: min(left, (1 << (OPERAND - 1)) - 1),
}


def operands(op):
    """Pairs of operands; FIT's left one is an operand, or just too long, and has no source."""
    rng = random.Random(int(op))
    ends = [-1 << (WORD - 1), -1, 0, 1, (1 << (WORD - 1)) - 1]
    top = 1 << (OPERAND - 1)
    if op == Op.FIT:
        return [(left, 0) for left in (-top, -1, 0, 1, top - 1, top)]
    return [(a, b) for a in ends for b in ends] + [
        (rng.randrange(-1 << bits, 1 << bits), rng.randrange(-1 << bits, 1 << bits)) for bits in range(1, WORD)
    ]


@pytest.mark.parametrize("op", WANT)
def test_results(op):
    dut = Alu(SIZES)

    async def bench(ctx):
        ctx.set(dut.op, op)
        ctx.set(dut.adds, op in ADDS)
        for left, source in operands(op):
            # FIT rounds: what the sum has is left, one of it from the carry
            for port, value in (("left", left - (op == Op.FIT)), ("source", source), ("addend", source)):
                ctx.set(getattr(dut, port), value)
            ctx.set(dut.carry, op == Op.FIT)
            await ctx.delay(1e-9)
            assert ctx.get(dut.result) == WANT[op](left, source)
            if op == Op.LIMIT:
                assert ctx.get(dut.limited) == (WANT[op](left, source) != source)

    simulated(dut, bench)


def test_lengths_and_shifts():
    dut = Alu(SIZES)

    async def bench(ctx):
        for value in (0, 1, 2, 3, 255, 256, (1 << (WORD - 1)) - 1):
            ctx.set(dut.op, Op.LENGTH)
            ctx.set(dut.source, value)
            await ctx.delay(1e-9)
            assert (ctx.get(dut.shifted) + 1) >> 1 == value.bit_length()
        ctx.set(dut.op, Op.SHIFT)
        for fine in range(1 << FINE):
            ctx.set(dut.coarse, 0x123456789)
            ctx.set(dut.fine, fine)
            await ctx.delay(1e-9)
            assert ctx.get(dut.shifted) % (1 << (WORD + 1)) == (0x123456789 >> fine) % (1 << (WORD + 1))

    simulated(dut, bench)
