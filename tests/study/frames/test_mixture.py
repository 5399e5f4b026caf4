"""What is drawn is what was declared, frame by frame, and nothing in it depends on how it is asked for."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.study.definitions import LAYER, MIXTURE, SENSOR, definition, section
from tfra.model.cover.contact import Contact, cell_shares
from tfra.model.cover.layer import frames
from tfra.runtime.errors import InputError
from tfra.study.frames.block import BLOCK, Block, Part
from tfra.study.frames.frameset import Definition
from tfra.study.frames.schema import Range

FILE = Path("study.toml")


def same(one: Block, other: Block) -> bool:
    arrays = ((one.stress, other.stress), (one.noisy, other.noisy), (one.shares, other.shares))
    return one.truth.equals(other.truth) and all(np.array_equal(a, b) for a, b in arrays)


def head(block: Block, count: int) -> Block:
    return Block(block.start, block.stress[:count], block.noisy[:count], block.shares[:count], block.truth.head(count))


def contacts_of(block: Block) -> list[Contact]:
    keys = ("shape", "center_x_m", "center_y_m", "half_x_m", "half_y_m", "force_z_n", "mu")
    return [
        Contact(*(row[key] for key in keys), 0.0 if np.isnan(row["phi_deg"]) else np.radians(row["phi_deg"]))
        for row in block.truth.rows(named=True)
    ]


def test_stress_and_shares_are_those_of_the_contacts_in_the_truth():
    block = definition().make(Part.TRAIN, 0)
    contacts = contacts_of(block)
    np.testing.assert_allclose(block.resultant, [c.force for c in contacts], atol=1e-14)
    np.testing.assert_allclose(block.mu, np.hypot(*block.resultant[:, :2].T) / -block.resultant[:, 2])
    exact = frames(SENSOR, contacts, LAYER.sampling, LAYER.poisson)
    np.testing.assert_allclose(block.stress, exact, rtol=2e-7, atol=1e-6 * np.abs(exact).max())
    np.testing.assert_allclose(block.shares, cell_shares(SENSOR, contacts), atol=1e-7)


def test_quantities_are_within_what_was_declared():
    truth = definition(train=BLOCK).make(Part.TRAIN, 0).truth
    first, second = (truth.filter(truth["component"] == number) for number in (1, 2))
    assert len(first) / len(truth) == pytest.approx(0.75, abs=0.05)
    assert set(first["shape"]) == {"hertz", "rounded"}
    assert set(second["shape"]) == {"uniform"}
    assert set((first["half_y_m"] / SENSOR.pitch_y).round(9)) == {1, 1.5, 2}
    half = first["half_x_m"] / SENSOR.pitch_x
    assert 0.5 <= half.min() < half.max() < 2.5
    assert (half < np.sqrt(0.5 * 2.5)).mean() == pytest.approx(0.5, abs=0.06)  # the logarithm is uniform
    assert first["force_z_n"].min() >= -10
    assert first["force_z_n"].max() <= -1
    assert first["mu"].mean() == pytest.approx(0.5, abs=0.05)
    assert set(first["offset_share_of_peak"]) == {-0.005, 0, 0.005}
    assert set(second["noise_share_of_peak"]) == {0}
    assert set(second["force_z_n"]) == {-2}
    assert second["phi_deg"].is_nan().to_list() == (second["mu"] == 0).to_list()
    assert set(second["phi_deg"].drop_nans()) == {30}
    low = first["center_x_m"] - first["half_x_m"] + SENSOR.pitch_x / 2
    assert low.min() >= -1e-12
    assert (first["center_x_m"] + first["half_x_m"] + SENSOR.pitch_x / 2).max() <= SENSOR.size_x + 1e-12
    share = low / (SENSOR.size_x - 2 * first["half_x_m"])
    assert share.mean() == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(second["center_y_m"], 2.5 * SENSOR.pitch_y)


def test_a_peak_in_place_of_a_force_scales_the_frame():
    by_force = definition().make(Part.TRAIN, 0)
    text = MIXTURE.replace("force_n = {from = -10, to = -1}", "peak_kpa = {from = 20, to = 180}")
    block = definition(text.replace("force_n = -2", "peak_kpa = 50")).make(Part.TRAIN, 0)
    peaks, second = np.abs(block.stress).max(axis=(1, 2)), block.truth["component"].to_numpy() == 2
    np.testing.assert_allclose(peaks[second], 50e3, rtol=1e-6)
    assert 20e3 <= peaks[~second].min() < 60e3 < 120e3 < peaks[~second].max() <= 180e3
    exact = frames(SENSOR, contacts_of(block), LAYER.sampling, LAYER.poisson)
    np.testing.assert_allclose(block.stress, exact, rtol=2e-7, atol=1e-6 * np.abs(exact).max())
    assert block.truth["mu"].equals(by_force.truth["mu"])


def test_noise_and_offset_are_shares_of_the_peak_and_noise_has_a_generator_of_its_own():
    block = definition().make(Part.TRAIN, 0)
    normal = np.random.default_rng(np.random.SeedSequence(7, spawn_key=(0, 0, 1))).standard_normal((40, 6, 8))
    noise, offset = (block.truth[f"{key}_share_of_peak"].to_numpy()[:, None, None] for key in ("noise", "offset"))
    peak = np.abs(block.stress).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(block.noisy, block.stress + peak * (noise * normal + offset), rtol=1e-5, atol=1e-2)
    quiet = (noise == 0).ravel() & (offset == 0).ravel()
    assert quiet.any()
    assert np.array_equal(block.noisy[quiet], block.stress[quiet])


@settings(max_examples=10, deadline=None)
@given(st.integers(1, 40))
def test_frame_i_is_the_same_however_many_are_asked_for(count):
    few, many = (definition(train=n).make(Part.TRAIN, 0) for n in (count, 40))
    assert len(few) == count
    assert same(few, head(many, count))


def test_the_second_block_does_not_need_the_first_nor_the_other_part():
    one, other = definition(train=BLOCK + 3), definition(train=2 * BLOCK + 9, held_out=0)
    short, long = one.make(Part.TRAIN, 1), other.make(Part.TRAIN, 1)
    assert (short.start, len(short), len(long)) == (BLOCK, 3, BLOCK)
    assert same(short, head(long, 3))


def test_parts_blocks_and_seeds_share_no_frame():
    blocks = [
        definition(train=BLOCK + 20).make(Part.TRAIN, 0),
        definition(train=BLOCK + 20).make(Part.TRAIN, 1),
        definition().make(Part.HELD_OUT, 0),
        definition(seed=8).make(Part.TRAIN, 0),
    ]
    every = np.concatenate([block.stress for block in blocks])
    assert len(np.unique(every.reshape(len(every), -1), axis=0)) == len(every)


def test_a_range_with_log_over_negative_values():
    values = Range.model_validate({"from": -10, "to": -0.1, "log": True}).at(np.array([0, 0.5, 1]))
    np.testing.assert_allclose(values, [-10, -1, -0.1])


MOVING, FIXED = (f"center_x_share = {x}\ncenter_y_share = 0.5" for x in ("{from = 0, to = 1}", "1"))
WRONG = [
    ("weight = 3", "weight = 0", "mixture#1.weight: a number above 0 is needed, got 0"),
    ('shape = "uniform"', 'shape = "cone"', "mixture#2.shape: one of hertz, uniform, rounded is needed, got 'cone'"),
    ("to = 2.5, log", "to = 4.5, log", "mixture#1.half_x_pitches: a footprint of 2 x 4.5 pitches does not fit on the "),
    ("from = 0.5, to = 2.5", "from = 0, to = 2.5", "half_x_pitches: a range with log needs ends of one sign, got from"),
    ("from = -10, to = -1", "from = -1, to = -10", "mixture#1.force_n: a range upwards is needed, got from -1 to -10"),
    ("force_n = -2", "force_n = 2", "mixture#2.force_n: -1e+06 to -1e-06 is needed, got 2"),
    ("mu = [0, 0.5]", "mu = [0, 1.5]", "mixture#2.mu: 0 to 1 is needed, got 1.5"),
    ("center_y_share = 0.25", "center_y_share = -1", "mixture#1.center_y_share: 0 to 1 is needed, got -1"),
    (MOVING, FIXED, "mixture#2: without a range the same contacts would be in both parts"),
]


@pytest.mark.parametrize(("text", "changed", "complaint"), WRONG)
def test_a_wrong_component_is_told_in_one_line_with_its_key(text, changed, complaint):
    assert MIXTURE.count(text) == 1
    with pytest.raises(InputError) as caught:
        definition(MIXTURE.replace(text, changed))
    assert str(caught.value).startswith("study.toml: frames.mixture#")
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_one_part_alone_may_have_the_same_contacts_again():
    assert definition(MIXTURE.replace(MOVING, FIXED), held_out=0).blocks(Part.HELD_OUT) == 0


def test_finite_elements_are_refused():
    with pytest.raises(InputError, match=r"frames\.mixture: contacts in such numbers need solver"):
        Definition.of(FILE, SENSOR, replace(LAYER, solver="fem"), section())
