"""Errors of the stages: the reference is float TFRA taken apart, and an error is found where it is made."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from tests.marks import long
from tests.model.cases import make_design
from tests.study.signals.measured import stage_errors, stage_table
from tfra.model.cover.scenes import SENSORS, contact_codes, directed_codes, wild_codes
from tfra.model.fixed.tfra import pipeline
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.tfra.stages import Stage
from tfra.model.tfra import Tfra
from tfra.study.signals.instrument import instrument
from tfra.study.signals.tfra.reference import Decisions, Reference
from tfra.study.signals.tfra.signals import last_bits, only, stage_of, words

DESIGNS = {name: make_design(SENSORS[name]) for name in ("10×10, 4×2 mm, h 3 mm", "5×7, 3×3 mm, h 2 mm")}
SIGNALS = [
    "stress", "magnitude", "direction", "c33_inv", "sums_b", "n", "sums_n", "c33", "c31", "c32", "sums", "alpha",
    "beta", "e0", "e1", "normal0", "normal1", "p", "q", "b_z", "b_xy", "mu_ind", "mu_x", "mu_y", "d", "pinv1", "pinv2",
    "pinv3", "planes", "f_star", "gain", "mu", "phi", "resultant", "forces",
]  # fmt: skip
"""In the order of the data."""
SMALL = DESIGNS["5×7, 3×3 mm, h 2 mm"]
EXACT = {"stress", "magnitude"}
EXACT_ALONE = EXACT | {"p", "q", "b_z", "b_xy"}


def swept(design, codes):
    """Trace and codes of the swept frames of one chunk."""
    (trace,) = FixedTfra(design).traces(codes)
    keep = trace.frame.regular
    return only(trace, keep), codes[keep]


def row(table, signal, reference):
    return table.filter((pl.col("signal") == signal) & (pl.col("reference") == reference)).row(0, named=True)


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


@pytest.mark.parametrize("name", ["5×7, 3×3 mm, h 2 mm", *long("10×10, 4×2 mm, h 3 mm")])
def test_a_reference_fed_with_itself_is_itself(name):
    design = DESIGNS[name]
    trace, codes = swept(design, contact_codes(design, 100, seed=4))
    reference, decided = Reference(design), Decisions.of(design, trace)
    values = reference.from_codes(codes.reshape(len(codes), -1), decided)
    again = reference.from_inputs(values, decided)
    assert list(again) == SIGNALS
    for signal, value in again.items():
        assert value == pytest.approx(values[signal], rel=1e-9, abs=1e-9 * np.abs(value).max()), signal


def test_every_stage_has_signals():
    assert {stage_of(signal) for signal in SIGNALS} == set(Stage)


def test_words_of_every_signal_are_the_models():
    """Words times their last bit, against results as the decoder has them."""
    trace, codes = swept(SMALL, contact_codes(SMALL, 50, seed=1))
    found, grid = words(SMALL, trace), last_bits(SMALL, trace)
    assert grid.keys() < found.keys()
    assert all(len(word) == len(codes) for word in found.values())
    direction = found["direction"] * grid["direction"]
    assert np.linalg.norm(direction, axis=1) == pytest.approx(1)
    phi = np.degrees(np.arctan2(direction[:, 1], direction[:, 0])) % 360
    assert found["phi"] * grid["phi"] * 360 == pytest.approx(phi, abs=0.01)
    total = found["f_star"] * grid["f_star"]
    assert total == pytest.approx((found["planes"] * grid["planes"]).sum(axis=2), rel=1e-3, abs=2000)
    gain = found["magnitude"] / np.linalg.norm(total, axis=1)
    assert found["gain"] * grid["gain"] == pytest.approx(gain, rel=1e-4)
    assert (total * gain[:, None]) == pytest.approx(found["resultant"] * grid["resultant"], rel=1e-3, abs=20)


@pytest.mark.parametrize("name", DESIGNS)
def test_what_is_exact_and_what_is_not(name):
    design = DESIGNS[name]
    scenes = contact_codes(design, 100, seed=5), wild_codes(design, 100, seed=6), directed_codes(design)
    codes = np.concatenate(scenes)
    table = stage_table(design, [codes])
    for reference, exact in (("codes", EXACT), ("inputs", EXACT_ALONE)):
        rows = table.filter(pl.col("reference") == reference)
        assert rows["signal"].to_list() == SIGNALS
        assert rows["stage"].to_list() == [str(stage_of(signal)) for signal in SIGNALS]
        assert set(rows.filter("exact")["signal"]) == exact
        assert set(rows.filter(pl.col("sqnr_db").is_null())["signal"]) == exact
        assert (rows.filter("exact")["max_error_lsb"] == 0).all()
    alone = table.filter(pl.col("reference") == "inputs")
    rounded = alone.filter(pl.col("signal").is_in(["f_star", "sums", "resultant", "forces"]))
    assert (rounded["max_error_lsb"] <= 0.5 + 1e-6).all()
    assert (rounded["rms_error_lsb"] > 0.2).all()


def test_longer_words_have_smaller_errors():
    tables = []
    for formats in ("standard", "wide"):
        design = make_design(SMALL.sensor, formats)
        tables.append(stage_table(design, [contact_codes(design, 200, seed=7)]).filter(~pl.col("exact")))
    short, long = (t.filter(pl.col("reference") == "codes")["sqnr_db"].to_numpy() for t in tables)
    assert (long > short + 25).all()


def test_blocks_and_chunks_do_not_matter():
    codes = np.concatenate([contact_codes(SMALL, 400, seed=8), wild_codes(SMALL, 200, seed=9)])
    whole, parts = stage_errors(SMALL, [codes]), stage_errors(SMALL, iter(np.array_split(codes, 7)))
    assert (whole.frames, whole.left_out) == (parts.frames, parts.left_out) == (600, whole.left_out)
    assert whole.left_out > 0
    assert whole.decisions().equals(parts.decisions())
    one, other = (each.errors(instrument(SMALL)) for each in (whole, parts))
    assert one["exact"].equals(other["exact"])
    for column in ("words", "max_error_lsb", "rms_error_lsb"):  # products of other shapes round otherwise
        assert one[column].to_numpy() == pytest.approx(other[column].to_numpy(), rel=1e-6)


def test_an_error_is_the_stages_own_and_the_later_ones_whole(monkeypatch):
    """n that is 1000 too large at every taxel is 4000 in its even parity, and no error of later stages themselves."""
    codes = contact_codes(SMALL, 100, seed=10)
    before = stage_table(SMALL, [codes])

    def corrupted(solution, regular):
        n = original(solution, regular)
        n[:, :, 0] += 4000
        return n

    original = pipeline.weights
    monkeypatch.setattr(pipeline, "weights", corrupted)
    after = stage_table(SMALL, [codes])
    bias = [row(table, "n", "inputs")["bias_lsb"] for table in (before, after)]
    assert bias[1] - bias[0] == pytest.approx(4000 * 12 / 35)  # of 35 words that carry something 12 are even
    assert row(after, "n", "inputs")["sqnr_db"] < row(before, "n", "inputs")["sqnr_db"] - 40
    assert row(after, "c33", "codes")["rms_error_lsb"] > 10 * row(before, "c33", "codes")["rms_error_lsb"]
    for signal in ("c33_inv", "c33", "c31", "sums"):
        assert row(after, signal, "inputs")["rms_error_lsb"] < 1.5 * row(before, signal, "inputs")["rms_error_lsb"]
    assert row(after, "c33_inv", "codes") == row(before, "c33_inv", "codes")


def test_flips_are_counted_and_do_not_drown_the_arithmetic(monkeypatch):
    codes = contact_codes(SMALL, 200, seed=11)
    before = stage_errors(SMALL, [codes])
    flips = dict(before.decisions().select("decision", "flips").iter_rows())
    assert flips["sweep index"] < 5
    assert flips["swept variable"] == 0

    def shifted(*args):
        found = original(*args)
        return replace(found, index=np.where(found.index < SMALL.search.steps - 1, found.index + 2, 0))

    original = pipeline.sweep
    monkeypatch.setattr(pipeline, "sweep", shifted)
    after = stage_errors(SMALL, [codes])
    counts = {name: (frames, flips) for name, frames, flips in after.decisions().iter_rows()}
    assert counts["sweep index, by more than one step"][1] >= counts["sweep index"][0] - 5
    assert counts["swept variable"] == (counts["sign"][0], 0)
    # Where another candidate is left out for its limited result, the errors differ a little.
    largest = [row(found.errors(instrument(SMALL)), "forces", "codes")["max_error_lsb"] for found in (before, after)]
    assert largest[1] < 3 * largest[0]


def test_float_decides_by_itself(monkeypatch):
    """A quarter turn of the model's direction is another swept variable, of every frame that has one."""
    codes = contact_codes(SMALL, 50, seed=12)

    def turned(design, codes):
        found = original(design, codes)
        return replace(found, cos=-found.sin, sin=found.cos, sweep_y=~found.sweep_y)

    original = pipeline.centroids
    monkeypatch.setattr(pipeline, "centroids", turned)
    counts = {name: (frames, flips) for name, frames, flips in stage_errors(SMALL, [codes]).decisions().iter_rows()}
    assert counts["swept variable"][0] == counts["swept variable"][1] > 20
    assert counts["sign"] == (0, 0)


@pytest.mark.parametrize("count", [0, 3])
def test_frames_that_are_all_degenerate_have_no_errors(count):
    errors = stage_errors(SMALL, [np.zeros((count, 5, 7), dtype=np.int64)])
    assert errors.frames == errors.left_out == count
    assert errors.errors(instrument(SMALL)).is_empty()
