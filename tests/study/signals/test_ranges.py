"""Ranges: what is observed is what the model computes, and what leaves its word or its bound is found."""

from dataclasses import replace
from fractions import Fraction
from math import floor

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.model.cases import make_design
from tests.study.signals.measured import broken, ranges
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes, wild_codes
from tfra.model.fixed.butterfly import to_taxels
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.tfra.stages import Stage
from tfra.model.tfra import Status
from tfra.study.signals.ranges import Range
from tfra.study.signals.tfra import observation
from tfra.study.signals.tfra.observation import catalogue, observe
from tfra.study.signals.words import Observed, cast

DESIGN = make_design(SENSORS["5×7, 3×3 mm, h 2 mm"])
NAMES = ("5×7, 3×3 mm, h 2 mm", "10×10, 4×2 mm, h 3 mm")


def scenes(design, count=100):
    contacts, wild = contact_codes(design, count, seed=1), wild_codes(design, count, seed=2)
    return np.concatenate([contacts, wild, directed_codes(design)])


def observed(design, codes):
    (trace,) = FixedTfra(design).traces(codes)
    return trace, observe(design, trace)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("formats", ["standard", "wide"])
def test_observed_words_are_the_models(name, formats):
    design = make_design(SENSORS[name], formats)
    trace, seen = observed(design, scenes(design))
    assert seen.keys() == catalogue(design).keys()
    vectors = {"contact": trace.contact, "residual": trace.residual, "force": trace.force}
    expected = {k: v for stack, words in vectors.items() for k, v in design.stacks[stack].split(words).items()}
    expected |= {"normal0": trace.normal[0], "normal1": trace.normal[1], "sums.operand": trace.affine.sums}
    expected |= {"f_star.division": trace.total.words, "resultant": trace.scaled.resultant}
    expected |= {"forces": trace.scaled.forces, "gain": trace.factor.mantissa}
    for signal, words in expected.items():
        np.testing.assert_array_equal(seen[signal].values, words, signal)
    np.testing.assert_array_equal(to_taxels(design, seen["force"].values), trace.planes)
    direction = np.stack([trace.direction.cos, trace.direction.sin], axis=1)
    some = ~trace.direction.vanishing
    np.testing.assert_array_equal(seen["direction.operand"].values[some], direction[some])
    k = design.search.steps
    middle = k * (trace.p - np.where(trace.direction.negative[:, None], trace.q, 0)) + k // 2 * trace.q
    ends = seen["candidate"].values
    assert ((ends.min(axis=1) <= middle) & (middle <= ends.max(axis=1))).all()


@given(st.lists(st.integers(-(1 << 40), 1 << 40), min_size=1), st.integers(-8, 40), st.integers(2, 30))
def test_losses_are_those_of_exact_rationals(values, shift, bits):
    seen = cast(np.array(values), shift, bits)
    exact = [Fraction(value) / Fraction(2) ** shift for value in values]
    rounded = [floor(x + Fraction(1, 2)) for x in exact]
    low, high = -(1 << (bits - 1)), (1 << (bits - 1)) - 1
    assert seen.values.tolist() == [min(max(x, low), high) for x in rounded]
    assert seen.rounded == sum(x.denominator > 1 for x in exact)
    assert seen.saturated == sum(not low <= x <= high for x in rounded)


def test_quotients_and_the_grid_count_as_rounded_when_they_are():
    trace, seen = observed(DESIGN, scenes(DESIGN))
    rounded = [0, 0, 0]
    for frame in np.flatnonzero(trace.frame.regular & ~trace.affine.vanishing):
        quotient = seen["quotient.division"].values[frame].tolist()
        rounded[0] += (Fraction(quotient[0], quotient[2]) * 2**15).denominator > 1
        rounded[1] += (Fraction(quotient[1], quotient[2]) * 2**15).denominator > 1
    for index in trace.chosen.index[trace.frame.regular].tolist():
        rounded[2] += (Fraction(index, 100) * 2**15).denominator > 1
    assert [seen[signal].rounded for signal in ("alpha", "beta", "mu_ind")] == rounded
    assert rounded[0] > 50


def test_saturations_are_those_that_the_status_tells():
    codes = wild_codes(DESIGN, 30, seed=3)
    flagged = 0
    for frame in codes[:, None]:
        trace, seen = observed(DESIGN, frame)
        limited = sum(seen[signal].saturated for signal in ("resultant", "forces", "gain", "mu"))
        assert (limited > 0) == bool(trace.scaled.saturated[0])
        flagged += bool(FixedTfra(DESIGN)(frame).words[0, -1] & Status.OUTPUT_SATURATED)
    assert flagged > 1


@pytest.mark.parametrize(
    ("minimum", "maximum", "signed", "bits"),
    [(-8192, 8191, True, 14), (-8193, 0, True, 15), (0, 8192, True, 15), (-1, 0, True, 1), (0, 0, True, 1),
     (0, 0, False, 0), (0, 255, False, 8), (3, 256, False, 9)],
)  # fmt: skip
def test_bits_of_a_range(minimum, maximum, signed, bits):
    assert Range(minimum, maximum, 2, 0, 0).bits(signed) == bits


def test_literal_ranges():
    """The first taxel of 5×7 compressed at full scale, where u = 7 and v = 5, and one code of traction beside it."""
    codes = np.zeros((1, 5, 7), dtype=np.int64)
    codes[0, 0, 0], codes[0, 0, 1] = -8192, 1
    table = ranges(DESIGN, [codes])
    rows = {row["signal"]: row for row in table.iter_rows(named=True)}
    assert [rows["stress"][key] for key in ("minimum", "maximum", "bits", "headroom_bits")] == [-8192, 1, 14, 0]
    assert rows["magnitude"]["maximum"] == 8193
    assert (rows["moment"]["minimum"], rows["moment"]["maximum"]) == (5, 7 * 8192)
    assert rows["moment"]["bits_needed"] == 16
    assert (rows["direction"]["minimum"], rows["direction"]["maximum"]) == (
        -8192,
        0,
    )  # U_t S_c - U_c S_t = 6·8192 - 7·8192
    assert rows["stress"]["words"] == 35
    assert rows["stress"]["rounded"] == rows["stress"]["saturated"] == 0
    assert rows["phi"]["rounded"] is None
    order = list(Stage)
    assert table["stage"].to_list() == sorted(table["stage"], key=order.index)


def test_blocks_do_not_matter():
    codes = scenes(DESIGN, 400)
    assert ranges(DESIGN, [codes]).equals(ranges(DESIGN, iter(np.array_split(codes, 5))))


@pytest.mark.parametrize("name", SENSORS)
def test_nothing_leaves_its_word_or_its_bound(name):
    design = make_design(SENSORS[name])
    assert not len(broken(ranges(design, [scenes(design, 50)])))


@pytest.mark.parametrize("field", ["stress", "accumulator", "moment", "magnitude"])
def test_a_word_that_is_too_short_is_found(field):
    design = make_design(DESIGN.sensor)
    widths = design.widths
    design.__dict__["widths"] = replace(widths, **{field: getattr(widths, field) - 1})
    found = broken(ranges(design, [scenes(design)]))
    assert set(found["word"]) == {field}


def test_a_bound_that_is_too_small_is_found(monkeypatch):
    original = observation.bounds

    def corrupted(design, stacks):
        found = original(design, stacks)
        found["vector"]["c33_inv"] *= 0.5
        return found

    monkeypatch.setattr(observation, "bounds", corrupted)
    assert broken(ranges(DESIGN, [scenes(DESIGN)]))["signal"].to_list() == ["c33_inv"]


def test_a_word_of_a_format_may_be_full():
    """Words that are moved to fill a format, or limited to it, are not broken: their ``bound`` is where it ends."""
    table = ranges(DESIGN, [scenes(DESIGN)]).filter(~pl.col("proven"))
    assert (table["headroom_bits"] >= 0).all()
    full = table.filter(pl.col("signal").str.ends_with(".operand") | pl.col("signal").str.ends_with(".division"))
    assert (full["headroom_bits"] == 0).all()


def test_a_range_forgets_nothing():
    one, other = (Range.of(Observed(np.array(values), 1, 2)) for values in ([3, -7], [9, 1, 1]))
    assert one | other == Range(-7, 9, 5, 2, 4)
    assert (one | Range.of(Observed(np.array([0]), None))).rounded is None
    assert (one | other).magnitude == 9
