"""Fast frames against the exact series, which shares the layer's transfer functions alone; and the prior's loads."""

from dataclasses import replace

import numpy as np
import pytest

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.layer import ElasticLayer
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.sensor import SensorArray
from tfra.train.pool import CHUNK, PAIR_WEIGHT, Pool
from tfra.train.prior import LARGEST, MARGIN, SHARE, Loads, random_cover, random_loads
from tfra.train.simulator import Cover, grid_count, responses

ROUGH = 1e-3
"""Share of the peak."""


def as_loads(contacts: list[Contact]) -> Loads:
    """The same shapes in the prior's terms."""
    count = len(contacts)
    return Loads(
        center=np.array([(c.center_x, c.center_y) for c in contacts]),
        half=np.array([(c.half_x, c.half_y) for c in contacts]),
        angle=np.zeros(count),
        power=np.array([0.0 if c.shape == ContactShape.UNIFORM else 0.5 for c in contacts]),
        square=np.array([c.shape != ContactShape.HERTZ for c in contacts]),
        tilt=np.zeros((count, 2)),
        sticking=np.zeros(count),
        edge=np.ones(count),
    )


def simulated(sensor: SensorArray, cover: Cover, loads: Loads, forces: Floats, points: int = 128) -> Floats:
    units = forces * [1, 1, -1]
    return np.einsum("nfij,nf->nij", responses(sensor, cover, loads.grids(points)), units)


def worst(exact: Floats, found: Floats) -> float:
    return float((np.abs(exact - found).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))).max())


def cover_of(sensor: SensorArray, kind: str) -> Cover:
    window = (sensor.pitch_x, sensor.pitch_y) if kind == "area" else (0.0, 0.0)
    margin = MARGIN * sensor.thickness if kind == "continued" else 0.0
    return Cover(ElasticLayer.under(sensor, 0.46, 1.03 * sensor.thickness, margin), window)


@pytest.mark.parametrize("kind", ["point", "area", "continued"])
@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_frames_are_those_of_the_exact_series(sensor: SensorArray, kind: str) -> None:
    contacts, cover = random_contacts(sensor, 12, np.random.default_rng(3)), cover_of(sensor, kind)
    x, y = np.arange(sensor.columns) * sensor.pitch_x, np.arange(sensor.rows) * sensor.pitch_y
    exact = cover.layer.base_stress(contacts, x, y, cover.window) * sensor.taxel_area
    forces = np.array([c.force for c in contacts])
    assert worst(exact, simulated(sensor, cover, as_loads(contacts), forces)) < ROUGH
    assert worst(exact, simulated(sensor, cover, as_loads(contacts), forces * [1, -1, 1])) > ROUGH
    wrong = Cover(replace(cover.layer, poisson=0.48), cover.window)
    assert worst(exact, simulated(sensor, wrong, as_loads(contacts), forces)) > ROUGH


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_a_finer_grid_of_point_forces_changes_nothing_but_the_edge(sensor: SensorArray) -> None:
    """The default grid is fine enough: smooth pressures of any place, size and rotation agree with a fine one."""
    rng = np.random.default_rng(4)
    loads = random_loads(sensor, 64, rng)
    smooth = replace(loads, power=np.full(64, 2.0))
    points, cover = grid_count(float(2 * loads.reach.max()), sensor.thickness), cover_of(sensor, "point")
    forces = np.tile([0.4, 0.3, -1.0], (64, 1))
    fine = simulated(sensor, cover, smooth, forces, 4 * points)
    assert worst(fine, simulated(sensor, cover, smooth, forces, points)) < ROUGH
    assert worst(fine, simulated(sensor, cover, smooth, forces, 4)) > ROUGH


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_loads_lie_on_the_block_and_have_the_stated_sizes(sensor: SensorArray) -> None:
    loads = random_loads(sensor, 5000, np.random.default_rng(5))
    pitch, block = np.array([sensor.pitch_x, sensor.pitch_y]), np.array([sensor.size_x, sensor.size_y])
    assert (loads.center - loads.reach >= -pitch / 2 - 1e-12).all()
    assert (loads.center + loads.reach <= block - pitch / 2 + 1e-12).all()
    assert (loads.half <= np.maximum(LARGEST * pitch, SHARE * block) + 1e-12).all()
    grids = loads.grids(24)
    for shares in (grids.pressure, grids.traction):
        np.testing.assert_allclose(shares.sum(axis=(1, 2)), 1.0, rtol=1e-12)
        assert (shares >= 0).all()
        empty = shares.max(axis=1).min(axis=1) == 0
        assert not empty[loads.square & (loads.angle == 0) & (loads.tilt == 0).all(axis=1)].any()
    sticks = (grids.pressure != grids.traction).any(axis=(1, 2))
    assert np.array_equal(sticks, loads.sticking > 0)
    assert 0.17 < sticks.mean() < 0.23


@pytest.mark.parametrize("square", [False, True])
def test_the_traction_of_a_load_that_sticks_is_a_difference_of_pressures(square: bool) -> None:
    """p (1 - s inside^b) with p = inside^a is a difference of two pressures, whose volumes are known."""
    sensor, one, sticking = SensorArray(10, 10, 4e-3, 2e-3, 3e-3), np.ones(1), 0.9
    place, half = np.full((1, 2), 0.015), np.array([[5e-3, 4e-3]])
    wide = Loads(place, half, 0 * one, one, np.array([square]), np.zeros((1, 2)), sticking=0 * one, edge=one)
    load, narrow = replace(wide, sticking=sticking * one), replace(wide, power=2 * one)
    volumes = (4 / 3) ** 2 / 4, (16 / 15) ** 2 / 4  # over the square of twice the half sides
    if not square:
        volumes = 1 / 2, 1 / 3  # over the ellipse's area
    cover, points = cover_of(sensor, "point"), 96
    found, all_of_it, middle = (responses(sensor, cover, each.grids(points)) for each in (load, wide, narrow))
    expected = (volumes[0] * all_of_it - sticking * volumes[1] * middle) / (volumes[0] - sticking * volumes[1])
    assert worst(expected[0, :2], found[0, :2]) < ROUGH
    assert worst(all_of_it[0, :2], found[0, :2]) > 0.1
    assert np.array_equal(all_of_it[0, 2], found[0, 2])


def test_a_rotation_by_a_right_angle_exchanges_the_half_sizes() -> None:
    def one(half: tuple[float, float], angle: float, square: bool) -> Loads:
        zero = np.zeros((1, 2))
        every = np.array([half]), np.array([angle]), np.array([1.0]), np.array([square]), zero
        return Loads(zero, *every, sticking=np.array([0.5]), edge=np.array([1.0]))

    for square in (False, True):
        turned, upright = one((2.0, 1.0), np.pi / 2, square), one((1.0, 2.0), 0.0, square)
        np.testing.assert_allclose(turned.reach, upright.reach)
        for one_way, other in zip(turned.grids(16)[2:], upright.grids(16)[2:], strict=True):
            np.testing.assert_allclose(one_way, other, atol=1e-12)


def test_covers_are_of_both_kinds() -> None:
    sensor, rng = next(iter(SENSORS.values())), np.random.default_rng(6)
    covers, wrong = zip(*(random_cover(sensor, rng) for _ in range(200)), strict=True)
    assert {cover.layer.size_x > sensor.size_x for cover in covers} == {False, True}
    assert {cover.window for cover in covers} == {(0.0, 0.0), (sensor.pitch_x, sensor.pitch_y)}
    deviation = np.array([abs(cover.layer.thickness / sensor.thickness - 1) for cover in covers])
    assert 0.02 < np.mean(wrong) < 0.12
    assert deviation[~np.array(wrong)].max() <= 0.03
    assert 0.1 <= deviation[np.array(wrong)].min() < deviation[np.array(wrong)].max() <= 0.3


def test_a_pool_follows_from_its_seed_and_its_frames_have_their_resultants() -> None:
    sensor = SensorArray(8, 9, 1e-3, 1e-3, 2e-3)
    done: list[int] = []
    pool, again, other = (Pool.simulate(sensor, 2, (seed, 0), done.append) for seed in (1, 1, 2))
    assert done == [1] * 6
    assert pool.responses.shape == (2 * CHUNK, 3, 72)
    assert np.array_equal(pool.responses, again.responses)
    assert not np.array_equal(pool.responses, other.responses)
    frames, forces, weight, peak, there = pool.draw(4000, np.random.default_rng(7))
    assert np.array_equal(peak[:, 0], np.abs(frames).max(axis=1))
    assert (there == 1).all()
    assert np.array_equal(frames, again.draw(4000, np.random.default_rng(7)).n)
    two = forces[:, 2] < -1
    assert np.array_equal(weight[:, 0], np.where(two, np.float32(PAIR_WEIGHT), np.float32(1)))
    assert not Pool(pool.responses, ~pool.wrong).draw(4000, np.random.default_rng(7)).weight.any()
    assert 0.09 < two.mean() < 0.15
    assert np.hypot(*forces.T[:2])[~two].max() <= 1.05 + 1e-6
    near = np.abs(frames.sum(axis=1) - forces[:, 2])  # the base carries the normal force, whatever the friction
    assert np.median(near) < 0.05
