"""Divider against its model: rounding, signs, limits, stalls and constant time."""

import random

import numpy as np
import pytest

from tests.marks import STALLS
from tfra.hdl.lib.divider import Divider
from tfra.model.fixed.numbers import divide
from tfra.sim.harness import run

SHAPES = [(9, 9, 7, 1), (22, 22, 15, 1), (12, 6, 10, 3), (5, 11, 0, 1), (31, 31, 24, 2)]
"""numerator, denominator, fraction, whole."""


def operands(shape, seed, number):
    """Quotients below 2^whole: at random, with equal operands and at the limits."""
    top_n, top_d, _, whole = ((1 << shape[0]) - 1, (1 << shape[1]) - 1, *shape[2:])
    rng = random.Random(seed)
    pairs = [(0, 1), (0, top_d), (1, 1), (1, top_d), (top_d, top_d), (top_n, top_d)]
    for d in (1, 2, 3, top_d // 3, top_d - 1, top_d):
        pairs += [((d << whole) - 1, d), ((d << whole) // 2, d), (d // 2, d), (d - 1, d)]
    while len(pairs) < number:
        d = rng.randrange(1, 1 << rng.randrange(1, shape[1] + 1))
        pairs.append((rng.randrange(d << whole), d))
    return [
        {"numerator": n, "denominator": d, "negative": rng.randrange(2)}
        for n, d in pairs
        if n <= top_n and n < d << whole
    ]


def expected(shape, sent):
    n = np.array([v["numerator"] * (1 - 2 * v["negative"]) for v in sent])
    return divide(n, np.array([v["denominator"] for v in sent]), shape[2]).tolist()


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_equals_the_model_in_a_time_that_does_not_depend_on_data(shape):
    """Quotients that are too long take the same time."""
    dut, sent = Divider(*shape), operands(shape, seed=1, number=80)
    assert {v["negative"] for v in sent} == {0, 1}
    longer = [{"numerator": (1 << shape[0]) - 1, "denominator": d, "negative": d & 1} for d in (0, 1, 2)]
    seen = run(dut, {"i": sent + longer}, {"o": len(sent + longer)})
    assert seen.values["o"][: len(sent)] == expected(shape, sent), "seed 1"
    assert {o - i for i, o in zip(seen.cycles["i"], seen.cycles["o"], strict=True)} == {dut.latency}
    assert set(np.diff(seen.cycles["o"])) == {dut.interval}


@pytest.mark.parametrize(("stall_in", "stall_out"), STALLS)
def test_survives_stalls(stall_in, stall_out):
    sent = operands(SHAPES[0], seed=2, number=40)[-16:]
    seen = run(Divider(*SHAPES[0]), {"i": sent}, {"o": len(sent)}, stall_in=stall_in, stall_out=stall_out, seed=2)
    assert seen.values["o"] == expected(SHAPES[0], sent), "seed 2"


@pytest.mark.parametrize(
    ("shape", "numerators", "denominator", "quotients"),
    [
        ((4, 4, 0), (1, 2, 3, 5, 6, 7), 4, (0, 1, 1, 1, 2, 2)),  # halves go away from zero
        ((6, 6, 4, 2), (0, 5, 63), 0, (64, 64, 64)),  # without a denominator, the limit
    ],
)
def test_literal_quotients(shape, numerators, denominator, quotients):
    sent = [{"numerator": n, "denominator": denominator, "negative": s} for s in (0, 1) for n in numerators]
    seen = run(Divider(*shape), {"i": sent}, {"o": len(sent)})
    assert seen.values["o"] == [*quotients, *(-q for q in quotients)]


def test_a_wrong_bit_is_noticed():
    sent = operands(SHAPES[0], seed=4, number=30)
    seen = run(Divider(*SHAPES[0]), {"i": sent}, {"o": len(sent)})
    sent[17]["numerator"] ^= 1 << 4
    assert seen.values["o"] != expected(SHAPES[0], sent)
