"""Loads against the exact series of the same pressures, and against integrals in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from bench.accuracy import loads
from bench.accuracy.loads import SHAPES, Cover, Shape, hertz, pair
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(5, 6, 4e-3, 3e-3, 3e-3)


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def drawn(count: int = 20) -> Contacts:
    return any_contacts(SENSOR, count, generator())


def off(found: Floats, exact: Floats) -> float:
    """Largest difference over the largest stress of its frame."""
    return float((np.abs(found - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))).max())


def test_the_sensors_own_cover_is_the_series() -> None:
    contacts = drawn()
    scene = Cover()(SENSOR, contacts, generator())
    assert off(scene.stress, frames(SENSOR, contacts)) < 1e-12
    assert np.array_equal(scene.force, contacts.force)


def test_other_covers_are_other_sensors() -> None:
    contacts, rng = drawn(), generator()
    thinner = frames(replace(SENSOR, thickness=0.9 * SENSOR.thickness), contacts)
    assert off(Cover(thickness=0.9)(SENSOR, contacts, rng).stress, thinner) < 1e-12
    mean = frames(SENSOR, contacts, "area", poisson=0.45)
    assert off(Cover(poisson=0.45, sampling="area")(SENSOR, contacts, rng).stress, mean) < 1e-12
    wide = replace(SENSOR, rows=SENSOR.rows + 10, columns=SENSOR.columns + 8)
    moved = replace(contacts, center=contacts.center + np.array([4, 5]) * (SENSOR.pitch_x, SENSOR.pitch_y))
    inner = frames(wide, moved)[:, 5:-5, 4:-4]
    assert off(Cover(margin=5.0)(SENSOR, contacts, rng).stress, inner) < 1e-3
    assert off(Cover()(SENSOR, contacts, rng).stress, inner) > 1e-2


def test_parts_of_a_known_shape_are_its_series() -> None:
    contacts = drawn()
    large = replace(contacts, shape=np.full(len(contacts), "hertz"), half=np.maximum(contacts.half, 3e-3))
    large = replace(large, center=np.broadcast_to([10e-3, 6e-3], large.center.shape))
    found = Shape(hertz, hertz)(SENSOR, large, generator())
    assert off(found.stress, frames(SENSOR, large)) < 0.01
    assert off(-found.stress, frames(SENSOR, large)) > 1


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_new_and_carry_the_force(name: str) -> None:
    contacts = replace(drawn(), half=np.full((20, 2), 4e-3), shape=np.full(20, "hertz"))
    contacts = replace(contacts, center=np.broadcast_to([10e-3, 6e-3], contacts.center.shape))
    scene = SHAPES[name](SENSOR, contacts, generator())
    assert np.array_equal(scene.force, contacts.force)
    assert 0.005 < off(scene.stress, frames(SENSOR, contacts)) < 1
    # rollers let the sum of the normal stress, the load's mean over the block, be F_z wherever it is
    total = scene.stress.sum(axis=(1, 2)) * SENSOR.taxel_area
    assert np.allclose(total, contacts.force[:, 2], rtol=0.25)


@pytest.mark.parametrize("mu", [0.1, 0.5, 1.0])
def test_partial_slip_is_mindlins(mu: float) -> None:
    axis = np.linspace(-1, 1, 801)
    u, v = axis[None, :], axis[:, None]
    zero, friction = np.zeros((1, 1)), np.full((1, 1), mu)
    pressure, traction = hertz(u, v, zero, friction), loads.slip(u, v, zero, friction)
    assert traction.sum() / pressure.sum() == pytest.approx(mu, rel=1e-3)
    slips = np.hypot(u, v) > np.cbrt(1 - mu)
    assert np.allclose(traction[slips], pressure[slips])
    assert (traction <= pressure + 1e-12).all()
    assert (traction >= -1e-12).all()


def test_other_pressures_at_some_points() -> None:
    u, zero = np.array([0.0, 0.4, 0.75, 1.1]), np.zeros(4)
    assert loads.ring(u, zero, zero, zero) == pytest.approx([0, 0, 0.25, 0])
    assert loads.punch(u, zero, zero, zero) == pytest.approx([1, 1 / np.sqrt(0.84), 1 / np.sqrt(0.4375), 0])
    assert loads.tilted(u, zero, zero, zero)[1] == pytest.approx(np.sqrt(0.84) * 1.8)
    assert loads.tilted(u, zero, zero + np.pi, zero)[2] == 0


def test_a_pair_is_two_of_the_contacts() -> None:
    contacts = drawn()
    one, both = Cover()(SENSOR, contacts, generator()), pair(SENSOR, contacts, generator())
    other = generator().permutation(len(contacts))
    added = both.stress - one.stress
    ratio = ((both.force - one.force) / contacts.force[other])[:, 2]
    assert np.allclose(added, ratio[:, None, None] * one.stress[other])
    share = (both.force - one.force)[:, 2] / contacts.force[:, 2]
    assert (share > 0.2).all()
    assert (share < 1).all()
