"""Windows of the training: those that the search lays, with other contacts and edges as they are."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding, finding
from tfra.train import patches
from tfra.train.patches import Patches, border_of, patch_of
from tfra.train.pool import random_forces

SENSOR = SensorArray(6, 9, 3e-3, 2e-3, 2.5e-3)


@pytest.fixture(scope="module")
def pool() -> Patches:
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(patches, "CHUNK", 64)
        return Patches.simulate(SENSOR, 4, (1, 2), lambda pieces: None)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patches, "CHUNK", 64)


def whole(pool: Patches, which: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Frames of whole patches with their border."""
    return np.einsum("ka,karc->krc", forces * [1, 1, -1], pool.responses[which])


def test_windows_are_those_that_the_search_lays(pool: Patches, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a contact that is alone."""
    monkeypatch.setattr(patches, "ASIDE", 0.0)
    rng = np.random.default_rng(3)
    which, forces = np.arange(len(pool.responses)), random_forces(len(pool.responses), rng)
    frames = whole(pool, which, forces)
    (rows, columns), patch = border_of(SENSOR), patch_of(SENSOR)
    inner = frames[:, rows : rows + patch.rows, columns : columns + patch.columns]
    assert not np.delete(frames, np.s_[rows : rows + patch.rows], axis=1).any()
    assert not np.delete(frames, np.s_[columns : columns + patch.columns], axis=2).any()
    seen = finding(Finding(1), (SENSOR.rows, SENSOR.columns), 0.0, inner)
    corner = pool._corner(which, forces, rng)
    assert (corner == np.stack([seen.top, seen.left], axis=1)).all(axis=1).mean() > 0.98
    cut = pool._cut(which, forces, corner, (SENSOR.rows, SENSOR.columns)).reshape(-1, SENSOR.rows, SENSOR.columns)
    there = pool._there(corner).reshape(cut.shape)
    for k, (top, left) in enumerate(corner):
        expected = frames[k, top + rows : top + rows + SENSOR.rows, left + columns : left + columns + SENSOR.columns]
        np.testing.assert_allclose(cut[k], expected, atol=1e-6)
        at = np.indices(cut[k].shape) + np.array([top, left])[:, None, None]
        inside = ((at >= 0) & (at < np.array([patch.rows, patch.columns])[:, None, None])).all(axis=0)
        assert (there[k] == inside).all()
    assert not cut[there == 0].any()
    assert 0.1 < (there.min(axis=(1, 2)) == 0).mean() < 0.9


def test_a_contact_alone_is_a_load(pool: Patches, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patches, "CROWDED", 0.0)
    frames = pool.draw(300, np.random.default_rng(4))
    np.testing.assert_array_equal(frames.forces[:, 2], -1)
    assert (np.hypot(*frames.forces.T[:2]) <= 1.05).all()
    assert np.isin(frames.peak[:, 0], pool.height).all()
    assert (frames.weight == 0).mean() == pytest.approx(pool.wrong.mean(), abs=0.1)


def test_others_press_aside_and_are_no_part_of_the_target(pool: Patches, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same contacts alone and with others: these reach into the window, from a pitch away at least."""
    monkeypatch.setattr(patches, "ASIDE", 0.0)
    monkeypatch.setattr(patches, "CROWDED", 1.0)
    crowded = pool.draw(400, np.random.default_rng(5))
    far = replace(pool, center=np.zeros_like(pool.center))  # all in one place: none is apart enough
    alone = far.draw(400, np.random.default_rng(5))
    np.testing.assert_array_equal(crowded.forces, alone.forces)
    assert (np.abs(crowded.peak / alone.peak) > 1).mean() > 0.1
    monkeypatch.setattr(patches, "NEAREST", 1e9)
    lonely = pool.draw(400, np.random.default_rng(5))
    added = np.abs(crowded.n - lonely.n).max(axis=1) / np.abs(lonely.n).max(axis=1)
    assert (added > 0.01).mean() > 0.3
    np.testing.assert_array_equal(lonely.peak[:, 0], alone.peak[:, 0])


def test_patches_hold_the_largest_contacts() -> None:
    """However small the window is."""
    for rows, columns in ((2, 2), (4, 7), (10, 10), (12, 5)):
        patch = patch_of(replace(SENSOR, rows=rows, columns=columns))
        assert patch.rows >= max(10, 2 * rows)
        assert patch.columns >= max(10, 2 * columns)
