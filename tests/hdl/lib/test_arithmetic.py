"""Rounding against the model; counting zeros against Python, and what a register between its halves would hold."""

import random
from typing import Any

import pytest
from amaranth import Cat, Module, Shape, Signal, Value, signed, unsigned

from tests.hdl.bus.manager import simulated
from tfra.hdl.lib.arithmetic import leading_zeros, round_negated, round_off
from tfra.model.fixed.numbers import round_shift
from tfra.model.rounding import Rounding


def _words(width: int) -> list[int]:
    """Zero, every highest bit with nothing and with all below it, and any."""
    draw = random.Random(width)
    heads = [word for bit in range(width) for word in (1 << bit, (2 << bit) - 1)]
    return [0, *heads, *(draw.getrandbits(width) >> draw.randrange(width) for _ in range(100))]


@pytest.mark.parametrize("width", [1, 2, 7, 8, 9, 14, 15, 16, 17, 24, 26, 31, 32, 33, 40, 63, 64])
def test_zeros_above_the_highest_bit(width: int) -> None:
    m, value, halves = Module(), Signal(width), list[Value]()

    def between(word: Value) -> Value:
        halves.append(word)
        return word

    zeros, seen = Signal(8), Signal(64)
    m.d.comb += zeros.eq(leading_zeros(value, between))
    m.d.comb += seen.eq(Cat(halves))
    assert len(Cat(halves)) <= len(seen)
    always = (1 << len(Cat(halves))) - 1

    async def bench(ctx: Any) -> None:
        nonlocal always
        for word in _words(width):
            ctx.set(value, word)
            await ctx.delay(1e-9)
            assert ctx.get(zeros) == width - word.bit_length(), (width, word)
            always &= ctx.get(seen)

    simulated(m, bench)
    # Synthesis would keep its register, which begins at zero, and make one of all such registers of a core.
    assert always == 0


@pytest.mark.parametrize("rounding", Rounding)
@pytest.mark.parametrize("drop", [1, 2, 5])
@pytest.mark.parametrize("shape", [signed(7), unsigned(6)])
def test_every_word_is_rounded_as_in_the_model(shape: Shape, drop: int, rounding: Rounding) -> None:
    m, value, result = Module(), Signal(shape), Signal(signed(9))
    negated = Signal(signed(9))
    m.d.comb += result.eq(round_off(value, drop, rounding))
    m.d.comb += negated.eq(round_negated(value, drop))

    async def bench(ctx: Any) -> None:
        low = -64 if shape.signed else 0
        for word in range(low, low + (1 << shape.width)):
            ctx.set(value, word)
            await ctx.delay(1e-9)
            assert ctx.get(result) == round_shift(word, drop, rounding), word
            assert ctx.get(negated) == -round_shift(word, drop), word

    simulated(m, bench)
