"""What a calibration says of a sensor: gains, covers and dead taxels of the training's frames."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.learned.network import MIRRORS, butterfly_first
from tfra.model.sensor import SensorArray
from tfra.recordings.calibration import Calibration, Cover
from tfra.recordings.front_end import Array, FrontEnd
from tfra.recordings.input import Input
from tfra.train import loop, pool
from tfra.train.augment import augmented, broken
from tfra.train.known import UNKNOWN, Known
from tfra.train.loop import Trainer
from tfra.train.prior import random_cover

SENSOR = SensorArray(4, 6, 3e-3, 2e-3, 2.5e-3)
DEAD = (1, 2), (3, 5)
COVER = Cover(thickness_mm=3.0, thickness_error_mm=0.06, poisson=0.44, poisson_error=0.02)


def calibration() -> Calibration:
    known = Calibration.none(SENSOR)
    dead = known.dead.copy()
    dead[tuple(zip(*DEAD, strict=True))] = True
    return replace(known, dead=dead, cover=COVER, gain_error=np.linspace(0.0, 0.2, 24).reshape(4, 6))


def test_gains_have_the_error_of_their_taxel_in_every_frame() -> None:
    known = Known.of(calibration(), SENSOR)
    frames = np.full((20_000, 24), -2.0, np.float32)
    silent = np.zeros((20_000, 1), np.float32)  # without noise and offset
    found = augmented(frames, silent, np.random.default_rng(1), known.gain_error)
    assert found.dtype == np.float32
    assert (found[:, 0][found[:, 0] != 0] == -2).all()
    assert ((found != frames).sum(axis=1) > 20).all()
    alive = np.where(found == 0, np.nan, found)
    np.testing.assert_allclose(np.nanstd(alive / frames, axis=0), np.linspace(0.0, 0.2, 24), rtol=0.04, atol=1e-7)


def test_covers_are_those_that_the_calibration_allows() -> None:
    """CONFIG's has another thickness; a few are still wrong, by 10 to 30 %, and none is softer than it can be."""
    rng, acting = np.random.default_rng(2), Known(cover=COVER).under_cover(SENSOR)
    covers, wrong = zip(*(random_cover(acting, rng, COVER) for _ in range(4000)), strict=True)
    thickness = 1e3 * np.array([cover.layer.thickness for cover in covers])
    right, poisson = thickness[~np.array(wrong)], np.array([cover.layer.poisson for cover in covers])
    assert 0.04 < np.mean(wrong) < 0.08
    assert right.mean() == pytest.approx(3.0, abs=0.005)
    assert right.std() == pytest.approx(0.06, rel=0.05)
    off = np.abs(thickness[np.array(wrong)] / 3.0 - 1)
    assert 0.1 <= off.min() < off.max() <= 0.3
    assert poisson.mean() == pytest.approx(0.44, abs=0.002)
    assert poisson.std() == pytest.approx(0.02, rel=0.05)
    vague = COVER.model_copy(update={"thickness_error_mm": 3.0, "poisson_error": 1.0})
    for cover, _ in (random_cover(acting, rng, vague) for _ in range(200)):
        assert 0.0 <= cover.layer.poisson <= 0.5
        assert 0.7 <= cover.layer.thickness / acting.thickness <= 1.3


def frames_of(known: Known) -> Floats:
    """Those of a batch."""
    trainer = Trainer(SENSOR, (2, 2), 1, lambda pieces: None, known=known)
    inputs, _, _ = trainer._draw(0)
    frames, shape = np.empty((inputs.shape[1], 24)), trainer.shape
    frames[:, shape._places] = butterfly_first(inputs).transpose(1, 0, 2) / MIRRORS
    return frames.reshape(-1, 4, 6)


def test_every_frame_of_a_batch_is_one_of_the_front_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """The front end of the same sensor changes nothing in it: its dead taxels are already repaired."""
    for module, name, value in ((pool, "CHUNK", 64), (loop, "CHUNKS", 2), (loop, "VALIDATION", 1)):
        monkeypatch.setattr(module, name, value)
    front_end = FrontEnd(Array(SENSOR, Adc()), Input(dead=DEAD))
    frames, others = frames_of(Known.of(calibration(), SENSOR)), frames_of(UNKNOWN)
    assert np.abs(front_end(frames) - frames).max() < 1e-6
    assert (np.abs(front_end(others) - others).max(axis=(1, 2)) > 1e-4).mean() > 0.9


def test_a_dead_taxel_breaks_in_no_frame() -> None:
    frames = -np.random.default_rng(9).uniform(0.1, 1.0, (4000, 4)).astype(np.float32)
    frames[:, :3] = 0.0
    found = frames.copy()
    which = broken(found, np.random.default_rng(10), np.arange(3))
    assert len(which) > 100
    assert (found[:, :3] == 0).all()
    assert (found[which, 3] != frames[which, 3]).all()


def test_held_out_frames_are_those_that_the_front_end_delivers() -> None:
    known, n = Known.of(calibration(), SENSOR), np.random.default_rng(3).normal(size=(5000, 24))
    found = known.delivered(n)
    repaired = FrontEnd(Array(SENSOR, Adc()), Input(dead=DEAD))(found.reshape(-1, 4, 6)).reshape(n.shape)
    np.testing.assert_allclose(found, repaired, atol=1e-12)
    alive = np.delete(np.arange(24), known.dead)
    expected = np.linspace(0.0, 0.2, 24)[alive]
    np.testing.assert_allclose(np.std(found / n, axis=0)[alive], expected, rtol=0.06, atol=1e-12)
    assert np.array_equal(UNKNOWN.delivered(n), n)
