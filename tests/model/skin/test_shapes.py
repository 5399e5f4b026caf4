"""Contacts of the exact series: one of any size and shape is found once, and two fingers until they touch."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray
from tfra.model.skin.finding import Finding, Found, Mark, finding

PITCH = 3e-3
SENSOR = SensorArray(32, 32, PITCH, PITCH, PITCH)
WINDOW = (10, 10)
MIDDLE = 15.7 * PITCH


def pressed(shape: ContactShape, half: float, x: float = MIDDLE, force: float = -5.0, mu: float = 0.5) -> Contact:
    return Contact(shape, x, MIDDLE, half * PITCH, half * PITCH, force, mu, phi=0.7)


def found(stress: Floats, noise: float = 0.0) -> Found:
    """What is found in frames ``(n, rows, columns)``, as a converter reads them at half of full scale."""
    peak = np.abs(stress).max(axis=(1, 2), keepdims=True)
    noisy = stress / peak + noise * np.random.default_rng(1).normal(size=stress.shape)
    return finding(Finding(), WINDOW, 32, np.rint(4096 * noisy).astype(np.int64))


@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize("shape", list(ContactShape))
def test_one_contact_is_found_once_and_told_if_it_is_large(shape: ContactShape, noise: float) -> None:
    halves = (1, 2, 3, 4, 5, 6, 7, 8)
    seen = found(frames(SENSOR, [pressed(shape, half, mu=mu) for half in halves for mu in (0.0, 1.0)]), noise)
    assert (seen.found == 1).all()
    large = (seen.marks & Mark.LARGE) != 0
    assert not large[np.repeat(halves, 2) <= 4].any()
    assert large[np.repeat(halves, 2) >= 7].all()
    assert not (seen.marks & ~Mark.LARGE).any()


@pytest.mark.parametrize(("outer", "inner"), [(2, 1), (3, 2), (4, 1), (4, 2), (4, 3), (5, 3), (6, 4)])
def test_a_ring_is_found_once(outer: float, inner: float) -> None:
    """A square punch whose middle does not press."""
    whole, hole = (
        pressed(ContactShape.UNIFORM, outer, force=-(outer**2)),
        pressed(ContactShape.UNIFORM, inner, force=-(inner**2)),
    )
    assert found(frames(SENSOR, [whole]) - frames(SENSOR, [hole])).found.tolist() == [1]


@pytest.mark.parametrize("half", [1, 2, 3])
def test_two_fingers_are_two_until_they_touch(half: float) -> None:
    """The gap goes from four pitches to none; where one region borders on the other, that is told."""
    gaps = np.array([4, 3, 2, 1.5, 1, 0.5, 0, -1])
    stress, one = [], pressed(ContactShape.HERTZ, half)
    for gap in gaps:
        aside = (half + gap / 2) * PITCH
        pair = replace(one, center_x=MIDDLE - aside), replace(one, center_x=MIDDLE + aside, normal_force=-4.0)
        stress.append(frames(SENSOR, pair).sum(axis=0))
    seen = found(np.array(stress))
    assert seen.found[gaps >= 2].tolist() == [2, 2, 2]
    assert seen.found[-1] == 1
    assert (np.diff(seen.found) <= 0).all()
    touching = np.bincount(seen.frame, (seen.marks & Mark.TOUCHING) != 0, len(gaps)) > 0
    apart = gaps[touching]
    assert (apart <= 2).all()
    assert (seen.found[touching] == 2).all()
    assert touching.any()
