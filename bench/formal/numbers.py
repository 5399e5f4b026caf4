"""Arithmetic against its definition in rationals: rounding, saturation, comparison, division, rotation."""

from typing import Any

from amaranth import Const, Mux, Signal, signed, unsigned

from bench.formal.bench import Bench
from bench.formal.prove import Proof
from bench.formal.streams import RULE, SOON, stays, taken
from tfra.hdl.lib.arithmetic import (
    add_carry,
    add_or_subtract,
    leading_zeros,
    less,
    round_negated,
    round_off,
    round_top,
    saturate,
    shift_right,
)
from tfra.hdl.lib.divider import Divider
from tfra.model.rounding import Rounding

BITS, DROP = 24, 9
"""Of a word, and those of them that are rounded off."""


def rounding(bench: Bench, function: Any) -> None:
    """All three ways, of a signed word."""
    value, half, unit = bench.free(signed(BITS), "value"), 1 << (DROP - 1), 1 << DROP
    for way in Rounding:
        result = function(value, DROP, way)
        error = (result << DROP) - value
        holds = {
            Rounding.HALF_UP: (error > -half) & (error <= half),
            Rounding.HALF_EVEN: (error >= -half) & (error <= half) & ((error != half) & (error != -half) | ~result[0]),
            Rounding.TRUNCATE: (error > -unit) & (error <= 0),
        }[way]
        bench.claim(f"{way.value.replace('_', ' ')}", value[:DROP] != 0, holds)


def negated(bench: Bench, function: Any) -> None:
    """The sign and the rounding at once."""
    value, half = bench.free(signed(BITS), "value"), 1 << (DROP - 1)
    error = (function(value, DROP) << DROP) + value
    bench.claim("minus the value rounded half up", value[:DROP] != 0, (error >= -half) & (error < half))


def shifted(bench: Bench, function: Any) -> None:
    """By any amount, then rounded."""
    value, amount = bench.free(signed(BITS), "value"), bench.free(range(BITS), "amount")
    result = round_off(function(value, amount), 1)
    wide = Signal(signed(2 * BITS))
    bench.m.d.comb += wide.eq(value)
    half = (Const(1, 1) << amount) >> 1
    error = Signal(signed(2 * BITS))
    bench.m.d.comb += error.eq((result << amount) - wide)
    unit = Const(1, 2) << amount
    bench.claim(
        "with round_off it rounds half up", amount != 0, ((error << 1) > -unit) & ((error << 1) <= unit) & half.any()
    )


def saturating(bench: Bench, function: Any) -> None:
    """The nearest word of fewer bits."""
    value, bits = bench.free(signed(BITS), "value"), BITS - DROP
    top = (1 << (bits - 1)) - 1
    nearest = Mux(value > top, top, Mux(value < -top - 1, -top - 1, value))
    bench.claim("the nearest word", (value > top) | (value < -top - 1), function(value, bits) == nearest)
    bench.claim("a word that fits stays", nearest == value, function(value, bits) == value)


def comparison(bench: Bench, function: Any) -> None:
    """Of unsigned words."""
    a, b = (bench.free(BITS, name) for name in "ab")
    bench.claim("a < b", a < b, function(a, b) == 1)
    bench.claim("a >= b", a >= b, function(a, b) == 0)


def adding(bench: Bench, function: Any) -> None:
    """Either sign."""
    a, b, minus = bench.free(signed(BITS), "a"), bench.free(signed(BITS - DROP), "b"), bench.free(1, "minus")
    bench.claim("the difference", minus, function(a, b, minus) == a - b)
    bench.claim("the sum", ~minus, function(a, b, minus) == a + b)


def carrying(bench: Bench, function: Any) -> None:
    """With a carry."""
    a, b, carry = bench.free(BITS, "a"), bench.free(BITS - DROP, "b"), bench.free(1, "carry")
    bench.claim("the sum of two words and a bit", carry, function(a, b, carry) == a + b + carry)


def zeros(bench: Bench, function: Any) -> None:
    """Above the highest bit that is set."""
    value = bench.free(BITS, "value")
    count = function(value)
    wide = Signal(2 * BITS)
    bench.m.d.comb += wide.eq(value << count)
    bench.claim("shifted by them, the highest bit is set", value != 0, wide[BITS - 1 :] == 1)
    bench.claim("all, for zero", value == 0, count == BITS)


def top(bench: Bench, function: Any) -> None:
    """Of a word without leading zeros."""
    value, bits, half = bench.free(signed(BITS), "value"), BITS - DROP, 1 << (DROP - 1)
    result, most = function(value, bits), (1 << (bits - 1)) - 1
    error = (result << DROP) - value
    rounds = (error > -half) & (error <= half)
    saturates = value >= (most << DROP) + half
    bench.claim("rounded half up", ~saturates, rounds)
    bench.claim("or the greatest word", saturates, result == most)


NUMERATOR, DENOMINATOR, FRACTION, WHOLE = 5, 4, 2, 2


def divider(bench: Bench, Block: Any) -> None:
    """Every numerator and denominator of few bits; quotients that fit, and the denominator zero."""
    block = Block(NUMERATOR, DENOMINATOR, FRACTION, WHOLE)
    inner = bench.place(block)
    m, i, o = bench.m, block.i, block.o
    given = Signal(i.payload.shape())
    steps = Signal(range(block.latency + 2))
    with m.If(taken(i)):
        m.d.sync += given.eq(i.payload)
        m.d.sync += steps.eq(1)
    with m.Elif(taken(o)):
        m.d.sync += steps.eq(0)
    with m.Elif((steps != 0) & (steps != block.latency)):
        m.d.sync += steps.eq(steps + 1)
    stays(bench, o)
    magnitude, half = Signal(unsigned(len(o.payload))), given.denominator
    m.d.comb += magnitude.eq(Mux(o.payload < 0, -o.payload, o.payload))
    twice = given.numerator << (FRACTION + 1)
    low, high = ((magnitude << 1) - 1) * half, ((magnitude << 1) + 1) * half
    fits = o.valid & (given.numerator < (given.denominator << WHOLE))
    bench.claim("the quotient is the nearest one, half up", fits, (low.as_signed() <= twice) & (twice < high))
    bench.claim("with the sign", fits & (magnitude != 0), (o.payload < 0) == given.negative)
    bench.claim(
        "a denominator of zero gives the greatest",
        o.valid & (given.denominator == 0),
        magnitude == 1 << (WHOLE + FRACTION),
    )
    bench.claim(SOON, steps == block.latency, o.valid)
    bench.claim("a division is over before the next", steps != 0, ~i.ready)
    bench.lemma((inner["busy"] == (steps != 0)) & (inner["done"] == (steps == block.latency)))
    bench.lemma(steps <= block.latency)
    bench.lemma(inner["known"] == (steps >= 2))
    bench.lemma(
        ~((steps >= 1) & (steps < block.latency)) | (inner["left"] == (block._digits - steps)[: len(inner["left"])])
    )
    bench.lemma((steps < 2) | (inner["last"] == (steps == block.latency - 1)))


PROOFS = [
    Proof(
        round_off,
        rounding,
        {
            "half up": ("value + rounding.constant(drop)", "value + rounding.constant(drop) - 1"),
            "half even": ("value[: drop - 1].any() | value[drop]", "value[: drop - 1].any()"),
            "truncate": ("exact = value >> drop\n", "exact = (value + 1) >> drop\n"),
        },
    ),
    Proof(round_negated, negated, {"minus the value rounded half up": ("(1 << drop) - 1", "(1 << drop)")}),
    Proof(shift_right, shifted, {"with round_off it rounds half up": ("value).as_signed() >>", "value) >>")}),
    Proof(
        round_top,
        top,
        {
            "rounded half up": ("width - bits - 1 :", "width - bits :"),
            "or the greatest word": (
                "saturate(round_off(aligned[width - bits - 1 :].as_signed(), 1), bits)",
                "round_off(aligned[width - bits - 1 :].as_signed(), 1)[:bits].as_signed()",
            ),
        },
    ),
    Proof(
        saturate,
        saturating,
        {
            "the nearest word": ("Mux(value[-1], Const", "Mux(value[0], Const"),
            "a word that fits stays": ("| high.all()", ""),
        },
    ),
    Proof(
        leading_zeros,
        zeros,
        {
            "shifted by them, the highest bit is set": ("return _zeros(nodes)[1]", "return _zeros(nodes)[1] | 1"),
            "all, for zero": ("Const(1, 1), value", "Const(0, 1), value"),
        },
    ),
    Proof(
        less,
        comparison,
        {
            "a < b": ("high[-1] | (low", "high[-1] & (low"),
            "a >= b": ("& ~higher[-1]", ""),
        },
    ),
    Proof(
        add_or_subtract,
        adding,
        {
            "the difference": ("Cat(subtract, inverted)", "Cat(Const(0, 1), inverted)"),
            "the sum": ("value ^ subtract", "~value ^ subtract"),
        },
    ),
    Proof(add_carry, carrying, {"the sum of two words and a bit": ("Const(1, 1)", "Const(0, 1)")}),
    Proof(
        Divider,
        divider,
        {
            RULE: ("with m.Elif(self.o.ready)", "with m.Else()"),
            "the quotient is the nearest one, half up": ("difference << 1", "difference << 2"),
            "with the sign": ("Mux(operands.negative, -1, 1)", "1"),
            "a denominator of zero gives the greatest": ("positive | register", "positive & ~register"),
            SOON: ("done.eq(known & last)", "done.eq(known & last & positive)"),
            "a division is over before the next": ("ready.eq(~busy)", "ready.eq(~busy | done)"),
        },
        depth=11,
        reach=14,
        size=f"{NUMERATOR} by {DENOMINATOR} bits",
    ),
]
