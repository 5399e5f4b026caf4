"""Roundings in gateware give the model's words; cells of one family, and a row of the table."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.parts.rounding import DESIGNS, TARGETS, Finish, Word, cells, kinds, row, worth
from tfra.hdl.parallel.matvec.drain import FINE
from tfra.sim.harness import play
from tfra.study.errors.rounding import Rounding, rounded

DESIGN = DESIGNS["10×10, `standard`"]
WIDTHS = DESIGN.widths
LATENCY = 4


def results(rounding, sums, shifts):
    """Words of the gateware, ``shifts`` as the model counts them: to the left below zero."""
    cycles = [{"sum": s, "shift": shift + WIDTHS.alignment} for s, shift in zip(sums, shifts, strict=True)]
    seen = play(Word(DESIGN, rounding), [*cycles, *[{}] * LATENCY], ["result"])
    return [record["result"] for record in seen[LATENCY:]]


def expected(rounding, sums, shifts):
    return rounded(np.array(sums), np.array(shifts), rounding).tolist()


def words(rng, count):
    """Any sums and shifts whose results are words: all bits, few, and ties."""
    top = (1 << len(Word(DESIGN, Rounding.TRUNCATE).shift)) - 1
    shifts = rng.integers(-WIDTHS.alignment, min(top, WIDTHS.accumulator + 2), count)
    bits = np.minimum(WIDTHS.accumulator - 1, WIDTHS.vector - 2 + shifts)
    sums = rng.integers(-(1 << 62), 1 << 62, count) >> (62 - rng.integers(0, bits + 1))
    ties = (shifts > 0) & (shifts < bits) & (rng.random(count) < 0.3)
    place = np.where(ties, shifts, 1)
    return np.where(ties, (sums >> place << place) + (1 << (place - 1)), sums), shifts


@pytest.mark.parametrize(
    ("rounding", "halves"),
    [
        (Rounding.HALF_UP, [-2, -1, -1, 0, 0, 1, 1, 2, 2]),
        (Rounding.HALF_EVEN, [-2, -2, -1, 0, 0, 0, 1, 2, 2]),
        (Rounding.TRUNCATE, [-2, -2, -1, -1, 0, 0, 1, 1, 2]),
    ],
)
def test_literals(rounding, halves):
    """Halves, also at both steps of a long shift; a bit beside a half; no shift; to the left."""
    sums, shifts = list(range(-4, 5)), [1] * 9
    for far in (FINE, 20, 34):
        sums, shifts = sums + [k << (far - 1) for k in range(-4, 5)], shifts + [far] * 9
    found = results(rounding, sums, shifts)
    assert found == halves * 4
    near = [(1 << 19) + 1, -(1 << 19) + 1, (1 << 19) + (1 << 18), -(3 << 19) - 1]
    cut = rounding is Rounding.TRUNCATE
    assert results(rounding, near, [20] * 4) == ([0, -1, 0, -2] if cut else [1, 0, 1, -2])
    assert results(rounding, [-3, 0, 7], [0] * 3) == [-3, 0, 7]
    assert WIDTHS.alignment == 1
    assert results(rounding, [-3, 0, 7], [-1] * 3) == [-6, 0, 14]


@pytest.mark.parametrize("rounding", Rounding)
@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_words_are_the_models(rounding, seed):
    sums, shifts = words(np.random.default_rng(seed), 300)
    sums, shifts = sums.tolist(), shifts.tolist()
    assert results(rounding, sums, shifts) == expected(rounding, sums, shifts)


def test_another_rounding_is_noticed():
    sums, shifts = (each.tolist() for each in words(np.random.default_rng(1), 300))
    found = {rounding: results(rounding, sums, shifts) for rounding in Rounding}
    for rounding in Rounding:
        assert [other for other in Rounding if found[other] == expected(rounding, sums, shifts)] == [rounding]


@pytest.mark.long
def test_cells_of_a_family():
    """An adder of a word and the bit below it; half even has two registers more, also in the whole way."""
    pair, bits = (Rounding.HALF_UP, Rounding.HALF_EVEN), WIDTHS.vector
    finish = [kinds(cells(Finish(DESIGN, rounding), TARGETS["iCE40"])) for rounding in pair]
    assert finish[0] == [bits, bits - 1, bits]
    assert finish[1][0] > bits
    assert finish[1][1:] == [bits - 1, bits + 2]
    way = [kinds(cells(Word(DESIGN, rounding), TARGETS["iCE40"])) for rounding in pair]
    assert way[1][1:] == [way[0][1], way[0][2] + 2]


@pytest.mark.long
def test_worth():
    """The share of word lengths is small, and cut-off bits are another."""
    errors = worth(DESIGN, 300)
    assert all(0 < errors[rounding]["mu"] < 1e-3 for rounding in Rounding)
    assert errors[Rounding.TRUNCATE] != errors[Rounding.HALF_UP]


def test_row():
    def facts(lut, carry, ff):
        found = {"finish": {family: {"LUT4": lut, "CCU2C": carry, "TRELLIS_FF": ff} for family in TARGETS}}
        errors = {"force_difference_percent_of_true_force": 0.00325, "mu": 5.96e-5}
        return found | {"way": {"LUT4": 248}, "unhurried": {"LUT4": 211}, "errors": errors}

    both = {Rounding.HALF_UP: facts(1, 17, 33), Rounding.TRUNCATE: facts(0, 0, 35)}
    for rounding, words in (Rounding.HALF_UP, "1, 17, 33"), (Rounding.TRUNCATE, "−1, −17, +2"):
        name = rounding.replace("_", " ")
        assert row("d", rounding, both) == f"| d | {name} | {' | '.join([words] * 3)} | 248 | 211 | 32.5 | 59.6 |"
