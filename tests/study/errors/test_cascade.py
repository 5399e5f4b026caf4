"""Every step against direct calls of what it is made of, frame by frame."""

import math
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from tests.study.definitions import SENSOR, definition, design
from tests.study.frames.test_mixture import contacts_of, head
from tfra.model.converter import convert
from tfra.model.fixed.words import decode
from tfra.model.metrics import Contact, rotation_deg
from tfra.model.tfra import Status, Tfra
from tfra.study.errors.cascade import SIGNED, Cascade, Step, View, decision_column, differences, error_column
from tfra.study.frames.block import Block, Part


@pytest.fixture(scope="module")
def block() -> Block:
    return definition().make(Part.TRAIN, 0)


@pytest.fixture(scope="module")
def scores(block: Block) -> pl.DataFrame:
    return Cascade(block)(design())


def column(scores: pl.DataFrame, quantity: str, step: Step, view: View = View.TOTAL) -> np.ndarray:
    return scores[error_column(quantity, step, view)].to_numpy()


def estimates(block: Block) -> dict[Step, Contact]:
    """The four results by hand: the converter as a loop, the float algorithm with its threshold in pascals."""
    core = design()
    lsb = 400e3 / 2**11
    float_tfra = Tfra(SENSOR, 100, contact_threshold=core.adc.threshold * lsb)
    codes = np.array([min(2047, max(-2048, round(float(b) / lsb))) for b in block.noisy.ravel()])
    codes = codes.reshape(block.noisy.shape)
    return {
        Step.METHOD: float_tfra(block.stress),
        Step.NOISE: float_tfra(block.noisy),
        Step.CONVERTER: float_tfra(codes * lsb),
        Step.ARITHMETIC: decode(core, core.model(codes).words),
    }


def test_steps_are_direct_calls(block, scores):
    truth = [(*c.force, c.mu, math.degrees(c.phi) if c.mu else math.nan) for c in contacts_of(block)]
    for step, found in estimates(block).items():
        for i, (f_x, f_y, f_z, mu, phi) in enumerate(truth):
            g_x, g_y, g_z = found.resultant[i]
            modulus = math.hypot(f_x, f_y, f_z)
            expected = {
                "phi_deg": (found.phi_deg[i] - phi + 180) % 360 - 180,
                "mu": found.mu[i] - mu,
                "force_x_n": g_x - f_x,
                "force_y_n": g_y - f_y,
                "force_z_n": g_z - f_z,
                "force_modulus_percent_of_true_force": 100 * (math.hypot(g_x, g_y, g_z) / modulus - 1),
                "force_difference_percent_of_true_force": 100 * math.dist((f_x, f_y, f_z), (g_x, g_y, g_z)) / modulus,
            }
            for quantity, value in expected.items():
                here = column(scores, quantity, step)[i]
                assert here == pytest.approx(value, rel=1e-5, abs=1e-6, nan_ok=True), (step, i, quantity)


def test_taxels_forces_are_compared_as_one_vector(block, scores):
    true = np.stack(
        [np.outer(c.force, share.ravel()) for c, share in zip(contacts_of(block), block.shares, strict=True)]
    )
    before = true.reshape(len(block), -1)
    for step, found in estimates(block).items():
        here = found.forces.reshape(len(block), -1)
        for view, start in ((View.TOTAL, true.reshape(len(block), -1)), (View.OWN, before)):
            expected = 100 * np.sqrt(((here - start) ** 2).sum(axis=1) / (true**2).sum(axis=(1, 2)))
            found_here = column(scores, "taxel_forces_percent_of_true_taxel_forces", step, view)
            np.testing.assert_allclose(found_here, expected, rtol=1e-4, atol=1e-5)
        before = here


def test_own_shares_of_signed_quantities_add_up(scores):
    for quantity, signed in SIGNED.items():
        own = [column(scores, quantity, step, View.OWN) for step in Step]
        total = column(scores, quantity, Step.ARITHMETIC)
        if quantity == "phi_deg":
            known = ~np.isnan(total)
            assert 0 < known.sum() < len(total)  # some have no friction
            np.testing.assert_allclose(rotation_deg(total, np.sum(own, axis=0))[known], 0, atol=1e-4)
        elif signed:
            np.testing.assert_allclose(np.sum(own, axis=0), total, rtol=1e-5, atol=1e-5)
        else:
            assert (np.sum(own, axis=0) >= total * (1 - 1e-5)).all()
        assert np.array_equal(own[0], column(scores, quantity, Step.METHOD), equal_nan=True)


def test_a_corrupted_result_is_seen_in_its_step_and_what_follows(block, scores):
    moved = replace(block, noisy=block.noisy * np.float32(1.01))
    changed = Cascade(moved)(design())
    for step, alike in ((Step.METHOD, True), (Step.NOISE, False), (Step.CONVERTER, False)):
        one, other = (column(table, "force_z_n", step) for table in (scores, changed))
        assert np.array_equal(one, other) is alike
    truth = block.truth.with_columns(force_z_n=pl.col("force_z_n") - 1)
    shifted = Cascade(replace(block, truth=truth))(design())
    np.testing.assert_allclose(
        column(shifted, "force_z_n", Step.NOISE), column(scores, "force_z_n", Step.NOISE) + 1, rtol=1e-5
    )
    assert np.array_equal(
        column(shifted, "force_z_n", Step.NOISE, View.OWN), column(scores, "force_z_n", Step.NOISE, View.OWN)
    )


def test_decisions_are_those_behind_the_result():
    """The independent friction lies on the grid: k/K, or (k - K)/K on the negative side."""
    block = definition(train=500).make(Part.TRAIN, 0)
    scores = Cascade(block)(design())
    for step, found in estimates(block).items():
        decided = {key: scores[decision_column(key, step)].to_numpy() for key in ("sweep_y", "negative", "quadrant")}
        assert scores[decision_column("sweep_index", step)].to_list() == found.sweep_index.tolist()
        swept = (found.status & ~(Status.INPUT_SATURATED | Status.OUTPUT_SATURATED)) == 0
        assert swept.sum() > 200
        grid = (found.sweep_index - 100 * decided["negative"]) / 100
        mu_ind = np.where(decided["sweep_y"], found.mu_y, found.mu_x)
        np.testing.assert_allclose(mu_ind[swept], grid[swept], atol=1e-4)
        assert (decided["quadrant"] == found.phi_deg // 90)[swept].all()


@pytest.mark.parametrize("axis", [1, 2])
def test_quadrants_begin_on_the_axes(block, axis):
    """A frame that is its own mirror image has its force along an axis: 0, 90, 180 or 270 degrees, exactly."""
    alike = block.noisy / 2 + np.flip(block.noisy, axis) / 2
    scores = Cascade(replace(block, noisy=alike))(design())
    core = design()
    found = decode(core, core.model(convert(core, alike)).words)
    swept = (found.status & ~Status.INPUT_SATURATED) == 0
    assert set(found.phi_deg[swept]) == ({0, 180} if axis == 1 else {90, 270})
    assert (scores[decision_column("quadrant", Step.ARITHMETIC)].to_numpy() == found.phi_deg / 90)[swept].all()


def test_saturation_is_told_behind_the_converter(block, scores):
    clipped = (np.abs(block.noisy) > 400e3).any(axis=(1, 2))
    assert 0 < clipped.sum() < len(block)
    for step in Step:
        bits = scores[decision_column("status", step)].to_numpy() & Status.INPUT_SATURATED
        behind = step in (Step.CONVERTER, Step.ARITHMETIC)
        assert ((bits > 0) == (clipped & behind)).all()


def test_unknown_truth_is_unknown_and_the_rest_is_not(block, scores):
    blind = Block(
        0, block.stress, block.noisy, block.shares * np.nan, block.truth.with_columns(pl.col("mu") * math.nan)
    )
    found = Cascade(blind)(design())
    for step in Step:
        assert np.isnan(column(found, "mu", step)).all()
        assert np.isnan(column(found, "taxel_forces_percent_of_true_taxel_forces", step, View.OWN)).all()
        assert np.array_equal(column(found, "force_x_n", step), column(scores, "force_x_n", step))
    assert np.array_equal(column(found, "mu", Step.NOISE, View.OWN), column(scores, "mu", Step.NOISE, View.OWN))


def test_percent_of_nothing_is_undefined():
    none = Block(
        0,
        *np.zeros((3, 1, 6, 8), dtype=np.float32),
        pl.DataFrame({key: [0.0] for key in ("force_x_n", "force_y_n", "force_z_n", "mu", "phi_deg")}),
    )
    found = differences(none, none, none)
    assert [key for key, value in found.items() if np.isnan(value[0])] == [key for key in SIGNED if "percent" in key]


def test_a_block_of_one_frame(block, scores):
    one = Cascade(head(block, 1))(design())
    for name in one.columns:
        assert one[name][0] == pytest.approx(scores[name][0], rel=1e-4, abs=1e-5, nan_ok=True), name
