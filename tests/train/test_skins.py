"""Held-out errors of windows: an estimate that knows the truth has none."""

from dataclasses import replace

import numpy as np
import pytest

from bench.accuracy.skins import others, table, told
from bench.publish import ROOT, stored
from tfra.model.arrays import Floats
from tfra.model.cover.scenes import crowds, gaps
from tfra.model.sensor import SensorArray
from tfra.train import skins
from tfra.train.skins import Crowd, held_out, threshold

WINDOW = SensorArray(8, 8, 3e-3, 3e-3, 3e-3)
SINGLE = np.ones(40, dtype=np.int64)


def knowing(crowd: Crowd, factor: float = 1.0) -> skins.Estimate:
    """An estimate of single contacts, whose windows come in their order."""

    def estimate(n: Floats) -> Floats:
        assert n.shape == (len(crowd.force), WINDOW.taxels)
        assert (n.sum(axis=1) < 0).all()
        return np.concatenate([factor * crowd.force, np.zeros((len(n), 1))], axis=1)

    return estimate


def test_what_is_known_has_no_error() -> None:
    crowd = Crowd.of(WINDOW, SINGLE, 5)
    seen = crowd.see(WINDOW, knowing(crowd), 1e-3)
    assert (seen.missed, seen.invented) == (0, 0)
    assert set(skins.errors_of(seen, "x").values()) == {0.0}
    off = skins.errors_of(crowd.see(WINDOW, knowing(crowd, 1.1), 1e-3), "x")
    assert off["force_percent_95_x"] == pytest.approx(10.0)
    assert np.isinf(seen.gap).all()
    assert 0 < seen.edge.mean() < 1


def test_contacts_that_are_missed_and_invented_are_counted() -> None:
    crowd = Crowd.of(WINDOW, SINGLE, 5)
    hidden = replace(
        crowd, center=crowd.center + np.where(np.arange(40) < 4, 36e-3, 0.0)[:, None]
    )  # not where they are
    seen = hidden.see(WINDOW, knowing(hidden), 0.0)
    assert (seen.missed, seen.invented) == pytest.approx((0.1, 0.1))
    assert len(seen.force) == 36


def test_gaps_are_those_between_footprints() -> None:
    rng = np.random.default_rng(7)
    contacts, frame = crowds(SensorArray(40, 30, 2e-3, 3e-3, 3e-3), np.array([3, 0, 8, 1]), rng, gap=1.5, ratio=3.0)
    assert frame.tolist() == [0] * 3 + [2] * 8 + [3]
    pitch = np.array([2e-3, 3e-3])
    for number in (0, 2):
        own = np.flatnonzero(frame == number)
        for k in own:
            rest = own[own != k]
            apart = gaps(contacts.center[k], contacts.half[k], contacts.center[rest], contacts.half[rest], pitch)
            assert (apart >= 1.5).all()
            sides = [
                max((abs(c - contacts.center[k]) - h - contacts.half[k]) / pitch)
                for c, h in zip(contacts.center[rest], contacts.half[rest], strict=True)
            ]
            np.testing.assert_allclose(apart, sides)
    assert (contacts.center - contacts.half >= -pitch / 2 - 1e-12).all()
    assert (contacts.center + contacts.half <= np.array([30, 40]) * pitch - pitch / 2 + 1e-12).all()
    assert (contacts.force[:, 2] <= -1).all()
    assert (contacts.force[:, 2] >= -3).all()


def test_every_condition_has_its_errors() -> None:
    found = held_out(WINDOW, lambda n: np.tile([0.1, 0.0, -1.0, 0.0], (len(n), 1)), count=1)
    names = (
        "at_0",
        "at_0.001",
        "at_0.01",
        "gap_1_2",
        "gap_2_3",
        "gap_3_4",
        "gap_4_inf",
        "alone",
        "inside",
        "edge",
        "ratio_10",
    )
    assert {f"mu_{share}_{name}" for share in (50, 95) for name in names} <= set(found)
    assert 0 <= found["missed_at_0.001"] < 0.05
    assert 0 <= found["invented_at_0.001"] < 0.05


def test_the_threshold_is_a_quantile() -> None:
    def unsure(n: Floats) -> Floats:
        return np.stack([0 * n[:, 0], 0 * n[:, 0], -np.ones(len(n)), np.arange(len(n))], axis=1)

    assert threshold(WINDOW, unsure, count=26) == pytest.approx(24.5)


def test_the_page_has_the_errors_of_the_example() -> None:
    assert table() in (ROOT / "docs" / "skins.md").read_text()


def test_the_page_tells_the_record() -> None:
    """Of other skins, and of what the uncertainty tells."""
    page, record = (ROOT / "docs" / "skins.md").read_text(), stored("skins")
    for table_of in (others, told):
        assert table_of(record) in page
