"""Measures of signals: observed words are the model's, float64 is TFRA taken apart, and what is wrong is found."""

from dataclasses import replace
from fractions import Fraction
from math import floor

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.model.cases import make_design
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes, wild_codes
from tfra.model.fixed.butterfly import to_taxels
from tfra.model.fixed.tfra import pipeline
from tfra.model.fixed.tfra.pipeline import FixedTfra, Stage
from tfra.model.tfra import Status, Tfra
from tfra.study.report import signal_charts
from tfra.study.signals.instrument import only
from tfra.study.signals.measures import (
    Observed,
    bits_needed,
    cast,
    decision_table,
    range_of,
    range_table,
    stage_table,
    total,
)
from tfra.study.signals.tfra import observation
from tfra.study.signals.tfra.instrument import TfraInstrument
from tfra.study.signals.tfra.observation import catalogue, observe
from tfra.study.signals.tfra.reference import Decisions, Reference
from tfra.study.signals.tfra.signals import stage_of

NAMES = ("10×10, 4×2 mm, h 3 mm", "5×7, 3×3 mm, h 2 mm")
DESIGNS = {name: make_design(SENSORS[name]) for name in NAMES}
SMALL = DESIGNS["5×7, 3×3 mm, h 2 mm"]
SIGNALS = [
    "stress", "magnitude", "direction", "c33_inv", "sums_b", "n", "sums_n", "c33", "c31", "c32", "sums", "alpha",
    "beta", "e0", "e1", "normal0", "normal1", "p", "q", "b_z", "b_xy", "mu_ind", "mu_x", "mu_y", "d", "pinv1", "pinv2",
    "pinv3", "planes", "f_star", "gain", "mu", "phi", "resultant", "forces",
]  # fmt: skip
"""In the order of the data."""
EXACT = {"stress", "magnitude"}
EXACT_ALONE = EXACT | {"p", "q", "b_z", "b_xy"}


def ranges(design, blocks):
    traces = (trace for block in blocks for trace in FixedTfra(design).traces(block))
    return range_table(catalogue(design), total(map(TfraInstrument(design).ranges, traces)))


def measures(design, blocks):
    return total(map(TfraInstrument(design).measure, blocks))


def stages(design, codes):
    return stage_table(stage_of, measures(design, [codes]))


def scenes(design, count=100):
    contacts, wild = contact_codes(design, count, seed=1), wild_codes(design, count, seed=2)
    return np.concatenate([contacts, wild, directed_codes(design)])


def broken(table):
    """The rows that exceed a word or a proven bound."""
    return table.filter((pl.col("headroom_bits") < 0) | (pl.col("proven") & (pl.col("share") > 1)))


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
    trace, seen = observed(SMALL, scenes(SMALL))
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
    codes = wild_codes(SMALL, 30, seed=3)
    flagged = 0
    for frame in codes[:, None]:
        trace, seen = observed(SMALL, frame)
        limited = sum(seen[signal].saturated for signal in ("resultant", "forces", "gain", "mu"))
        assert (limited > 0) == bool(trace.scaled.saturated[0])
        flagged += bool(FixedTfra(SMALL)(frame).words[0, -1] & Status.OUTPUT_SATURATED)
    assert flagged > 1


@pytest.mark.parametrize(
    ("minimum", "maximum", "signed", "bits"),
    [(-8192, 8191, True, 14), (-8193, 0, True, 15), (0, 8192, True, 15), (-1, 0, True, 1), (0, 0, True, 1),
     (0, 0, False, 0), (0, 255, False, 8), (3, 256, False, 9)],
)  # fmt: skip
def test_bits_of_a_range(minimum, maximum, signed, bits):
    assert bits_needed(minimum, maximum, signed) == bits


def test_literal_ranges():
    """The first taxel of 5×7 compressed at full scale, where u = 7 and v = 5, and one code of traction beside it."""
    codes = np.zeros((1, 5, 7), dtype=np.int64)
    codes[0, 0, 0], codes[0, 0, 1] = -8192, 1
    table = ranges(SMALL, [codes])
    rows = {row["signal"]: row for row in table.iter_rows(named=True)}
    extremes = {
        signal: (rows[signal]["minimum"], rows[signal]["maximum"]) for signal in ("stress", "moment", "direction")
    }
    assert extremes == {"stress": (-8192, 1), "moment": (5, 7 * 8192), "direction": (-8192, 0)}  # 6·8192 - 7·8192
    assert [rows["stress"][key] for key in ("bits", "headroom_bits", "words", "rounded", "saturated")] == [
        14,
        0,
        35,
        0,
        0,
    ]
    assert rows["magnitude"]["maximum"] == 8193
    assert rows["moment"]["bits_needed"] == 16
    assert rows["phi"]["rounded"] is None
    assert table["stage"].to_list() == sorted(table["stage"], key=list(Stage).index)


def test_rows_of_parts_add_up():
    one, other, unknown = (
        {"ranges": {"a": range_of(Observed(np.array(values), rounded, 2))}}
        for values, rounded in (([3, -7], 1), ([9, 1, 1], 1), ([0], None))
    )
    assert total([one, other])["ranges"] == {
        "a": {"minimum": -7, "maximum": 9, "words": 5, "rounded": 2, "saturated": 4}
    }
    assert total([unknown, unknown])["ranges"]["a"]["rounded"] is None


def test_blocks_do_not_matter():
    codes = np.concatenate([contact_codes(SMALL, 400, seed=8), wild_codes(SMALL, 200, seed=9)])
    whole, parts = measures(SMALL, [codes]), measures(SMALL, iter(np.array_split(codes, 7)))
    assert whole["ranges"] == parts["ranges"]
    assert decision_table(whole).equals(decision_table(parts))
    for signal, row in whole["codes"].items():
        assert row == pytest.approx(parts["codes"][signal], rel=1e-6, abs=1e-3)  # other shapes round otherwise


@pytest.mark.parametrize("name", SENSORS)
def test_nothing_leaves_its_word_or_its_bound(name):
    """Nor does a bar of the chart its tick; mu_ind is at both ends of its range, which take 17 bits."""
    design = make_design(SENSORS[name])
    table = ranges(design, [scenes(design, 50)])
    assert not len(broken(table))
    (chart_ticks,) = signal_charts.ranges({"ranges": table}).select_traces({"name": "needed for the proven bound"})
    proven = table.filter("proven").with_columns(tick=pl.Series(chart_ticks.x))
    assert proven.filter(pl.col("bits_needed") > pl.col("tick"))["signal"].to_list() == []
    assert proven.filter(pl.col("tick") > pl.col("bits"))["signal"].to_list() == []
    ends = proven.filter(signal="mu_ind").select("minimum", "maximum", "bound", "bits_needed", "tick").row(0)
    assert ends == (-(2**15), 2**15, 2**15, 17, 17)
    full = table.filter(pl.col("signal").str.ends_with(".operand") | pl.col("signal").str.ends_with(".division"))
    assert (full["headroom_bits"] == 0).all()


@pytest.mark.parametrize("field", ["stress", "accumulator", "moment", "magnitude"])
def test_a_word_that_is_too_short_is_found(field):
    design = make_design(SMALL.sensor)
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
    assert broken(ranges(SMALL, [scenes(SMALL)]))["signal"].to_list() == ["c33_inv"]


def swept(design, codes):
    """Trace and codes of the swept frames of one chunk."""
    (trace,) = FixedTfra(design).traces(codes)
    keep = trace.frame.regular
    return only(trace, keep), codes[keep]


@pytest.mark.parametrize("name", DESIGNS)
def test_the_reference_is_float_tfra_where_both_decide_alike(name):
    design = DESIGNS[name]
    trace, codes = swept(design, contact_codes(design, 200, seed=3))
    values = Reference(design).from_codes(codes.reshape(len(codes), -1), Decisions.of(design, trace))
    exact = Tfra.of(design)(codes * design.adc.lsb)
    same = exact.sweep_index == trace.chosen.index
    assert same.sum() > 100
    newton = design.adc.lsb * design.sensor.taxel_area * 2.0**-trace.frame.exponent
    forces = values["forces"] * newton[:, None, None]
    modulus = np.linalg.norm(exact.resultant, axis=1)
    apart = np.abs(forces - exact.forces.reshape(forces.shape)).max(axis=(1, 2)) / modulus
    assert apart[same].max() < 1e-9
    assert np.abs(values["resultant"] * newton[:, None] - exact.resultant)[same].max() < 1e-9 * modulus.max()
    assert values["phi"] * 360 % 360 == pytest.approx(exact.phi_deg, abs=1e-9)
    for signal in ("mu", "mu_x", "mu_y"):
        assert values[signal][same] == pytest.approx(getattr(exact, signal)[same], abs=1e-9)


@pytest.mark.parametrize("name", DESIGNS)
def test_what_is_exact_and_what_is_not(name):
    design = DESIGNS[name]
    assert {stage_of(signal) for signal in SIGNALS} == set(Stage)
    table = stages(design, scenes(design))
    for reference, exact in (("codes", EXACT), ("inputs", EXACT_ALONE)):
        rows = table.filter(reference=reference)
        assert rows["signal"].to_list() == SIGNALS
        assert rows["stage"].to_list() == [str(stage_of(signal)) for signal in SIGNALS]
        assert set(rows.filter("exact")["signal"]) == exact
        assert set(rows.filter(pl.col("sqnr_db").is_null())["signal"]) == exact
        assert (rows.filter("exact")["max_error_lsb"] == 0).all()
    rounded = table.filter(pl.col("signal").is_in(["f_star", "sums", "resultant", "forces"]), reference="inputs")
    assert (rounded["max_error_lsb"] <= 0.5 + 1e-6).all()
    assert (rounded["rms_error_lsb"] > 0.2).all()


def test_longer_words_have_smaller_errors():
    designs = [make_design(SMALL.sensor, formats) for formats in ("standard", "wide")]
    tables = [stages(design, contact_codes(design, 200, seed=7)) for design in designs]
    short, long = (table.filter(reference="codes", exact=False)["sqnr_db"].to_numpy() for table in tables)
    assert (long > short + 25).all()


def test_an_error_is_the_stages_own_and_the_later_ones_whole(monkeypatch):
    """n that is 1000 too large at every taxel is 4000 in its even parity, and no error of later stages themselves."""
    codes = contact_codes(SMALL, 100, seed=10)

    def corrupted(solution, regular):
        n = original(solution, regular)
        n[:, :, 0] += 4000
        return n

    def rows():
        return {(row["signal"], row["reference"]): row for row in stages(SMALL, codes).iter_rows(named=True)}

    before, original = rows(), pipeline.weights
    monkeypatch.setattr(pipeline, "weights", corrupted)
    after = rows()
    n = "n", "inputs"
    # Of 35 words that carry something 12 are even.
    assert after[n]["bias_lsb"] - before[n]["bias_lsb"] == pytest.approx(4000 * 12 / 35)
    assert after[n]["sqnr_db"] < before[n]["sqnr_db"] - 40
    assert after["c33", "codes"]["rms_error_lsb"] > 10 * before["c33", "codes"]["rms_error_lsb"]
    for signal in ("c33_inv", "c33", "c31", "sums"):
        assert after[signal, "inputs"]["rms_error_lsb"] < 1.5 * before[signal, "inputs"]["rms_error_lsb"]
    assert after["c33_inv", "codes"] == before["c33_inv", "codes"]


def test_flips_are_counted_and_do_not_drown_the_arithmetic(monkeypatch):
    codes = contact_codes(SMALL, 200, seed=11)
    before = measures(SMALL, [codes])
    assert before["flips"]["sweep index"]["flips"] < 5
    assert before["flips"]["swept variable"]["flips"] == 0

    def shifted(*args):
        found = original(*args)
        return replace(found, index=np.where(found.index < SMALL.search.steps - 1, found.index + 2, 0))

    original = pipeline.sweep
    monkeypatch.setattr(pipeline, "sweep", shifted)
    after = measures(SMALL, [codes])
    counts = after["flips"]
    assert counts["sweep index, by more than one step"]["flips"] >= counts["sweep index"]["frames"] - 5
    assert counts["swept variable"] == {"frames": counts["sign"]["frames"], "flips": 0}
    # Where another candidate is left out for its limited result, the errors differ a little.
    assert after["codes"]["forces"]["largest"] < 3 * before["codes"]["forces"]["largest"]


def test_float_decides_by_itself(monkeypatch):
    """A quarter turn of the model's direction is another swept variable, of every frame that has one."""

    def turned(design, codes):
        found = original(design, codes)
        return replace(found, cos=-found.sin, sin=found.cos, sweep_y=~found.sweep_y)

    original = pipeline.centroids
    monkeypatch.setattr(pipeline, "centroids", turned)
    counts = measures(SMALL, [contact_codes(SMALL, 50, seed=12)])["flips"]
    assert counts["swept variable"]["frames"] == counts["swept variable"]["flips"] > 20
    assert counts["sign"] == {"frames": 0, "flips": 0}


@pytest.mark.parametrize("count", [0, 3])
def test_frames_that_are_all_degenerate_have_no_errors(count):
    assert stages(SMALL, np.zeros((count, 5, 7), dtype=np.int64)).is_empty()
