"""Frames of a skin are what their truth says, apart as declared, and the same whenever they are drawn."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from tests.study.skins.definitions import MIXTURE, STUDY, a_block, study
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.study.frames.block import Block, Part
from tfra.study.skins.crowds import BLOCK, contacts_of


def test_a_frame_is_the_sum_of_its_contacts(tmp_path: Path) -> None:
    loaded, block = a_block(tmp_path)
    table, frame = contacts_of(block)
    sensor = loaded.skin.sensor
    every = [
        Contact(
            row["shape"],
            *(row[key] for key in ("center_x_m", "center_y_m", "half_x_m", "half_y_m", "force_z_n", "mu")),
            np.radians(row["phi_deg"]),
        )
        for row in table.rows(named=True)
    ]
    alone = frames(sensor, every)
    peaks = np.abs(alone).max(axis=(1, 2))
    assert (peaks >= 5e3).all()
    assert (peaks <= 100e3).all()
    for number in range(len(block)):
        together = alone[frame == number].sum(axis=0)
        np.testing.assert_allclose(block.stress[number], together, atol=1e-6 * np.abs(together).max())
    normal = loaded.definition.noise(Part.HELD_OUT, 0)[: len(block)]
    peak = np.abs(block.stress).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(block.noisy, block.stress + peak * (0.02 * normal + 0.01), rtol=1e-4, atol=1)


def test_contacts_are_as_many_and_as_far_apart_as_declared(tmp_path: Path) -> None:
    _, block = a_block(tmp_path, BLOCK)
    table, frame = contacts_of(block)
    counts = np.bincount(frame)
    assert len(counts) == BLOCK
    assert set(counts) == {1, 2, 3, 4}
    pitch = {"x": 3e-3, "y": 2.5e-3}
    for number in range(BLOCK):
        rows = table.filter(frame=number).rows(named=True)
        for k, row in enumerate(rows):
            apart = [
                max(
                    (abs(row[f"center_{a}_m"] - other[f"center_{a}_m"]) - row[f"half_{a}_m"] - other[f"half_{a}_m"])
                    / pitch[a]
                    for a in "xy"
                )
                for other in rows[:k] + rows[k + 1 :]
            ]
            assert min(apart, default=np.inf) >= 0.5
            assert row["gap_pitches"] == pytest.approx(min(apart, default=np.inf))
            assert row["center_x_m"] - row["half_x_m"] >= -1.5e-3 - 1e-12
            assert row["center_y_m"] + row["half_y_m"] <= 13.5 * 2.5e-3 + 1e-12


def test_a_frame_depends_on_its_part_and_number_alone(tmp_path: Path) -> None:
    loaded, block = a_block(tmp_path, 5)
    source = loaded.definition.source
    fewer, other = source.block(Part.HELD_OUT, 0, 3), source.block(Part.TRAIN, 0, 3)
    assert fewer.truth.equals(block.truth[:3])
    np.testing.assert_array_equal(fewer.stress, block.stress[:3])
    assert not np.array_equal(other.stress, fewer.stress)
    assert loaded.definition.blocks(Part.HELD_OUT) == 2
    assert source.block(Part.HELD_OUT, 1, 2).start == BLOCK
    again = Block.from_parquet(block.to_parquet(), 0, 14, 16)
    assert again.to_parquet() == block.to_parquet()
    assert again.truth.equals(block.truth)


def test_each_kind_has_its_own_number_of_contacts(tmp_path: Path) -> None:
    other = MIXTURE.replace("{ from = 1, to = 4 }", "[2, 3]").replace("= 0.02", "= 0.0").replace("= 0.5\n", "= 4.0\n")
    loaded = study(tmp_path, STUDY.replace(MIXTURE, MIXTURE.replace("{ from = 1, to = 4 }", "1") + other))
    truth = loaded.definition.source.block(Part.TRAIN, 0, 40).truth
    counts = truth.select("component", "noise_share_of_peak", count=pl.col("mu").list.len()).unique().sort("count")
    assert counts.rows() == [(1, 0.02, 1), (2, 0.0, 2), (2, 0.0, 3)]
    apart = truth.filter(component=2)["gap_pitches"].explode()
    assert apart.min() >= 4


def test_no_room_is_told(tmp_path: Path) -> None:
    far = STUDY.replace("gap_pitches = 0.5", "gap_pitches = 9.0").replace("from = 1, to = 4", "from = 3, to = 4")
    loaded = study(tmp_path, far)
    reason = r"^mixture#1.contacts: [34] contacts with a gap of 9 pitches find no room, \d do$"
    with pytest.raises(ValueError, match=reason):
        loaded.definition.source.block(Part.TRAIN, 0, 40)
