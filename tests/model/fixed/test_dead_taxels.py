"""Weights for dead taxels: near other contacts than those that were fitted, from sources that are alive and near."""

import numpy as np
import pytest

from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, any_contacts
from tfra.model.fixed.dead_taxels import SEED, SOURCES, repairs
from tfra.model.fixed.front_end import repair_places
from tfra.model.fixed.repair import HEADER, ONE, PLACE, repaired
from tfra.model.sensor import SensorArray

SENSOR = SENSORS["10×10, 4×2 mm, h 3 mm"]
BITS = 14


def dead(sensor: SensorArray, *places: tuple[int, int]) -> np.ndarray:
    mask = np.zeros((sensor.rows, sensor.columns), dtype=bool)
    for place in places:
        mask[place] = True
    return mask


def contacts(sensor: SensorArray) -> np.ndarray:
    """Codes ``(n, m)`` of 500 other contacts, their peaks at half of the range."""
    stress = frames(sensor, any_contacts(sensor, 500, np.random.default_rng(SEED + 1))).reshape(500, -1)
    return np.rint(stress / np.abs(stress).max(axis=1, keepdims=True) * 2 ** (BITS - 2)).astype(np.int64)


def lost(sensor: SensorArray, mask: np.ndarray, table: np.ndarray) -> float:
    """Root mean square of what is wrong at the taxels of ``mask``, of its value there."""
    codes, flat = contacts(sensor), mask.ravel()
    found, _ = repaired(np.where(flat, 0, codes), table, BITS)
    assert np.array_equal(found[:, ~flat], codes[:, ~flat])
    return float(np.linalg.norm((found - codes)[:, flat]) / np.linalg.norm(codes[:, flat]))


@pytest.mark.parametrize(
    ("places", "most"),
    [([(4, 4)], 0.12), ([(0, 0)], 0.3), ([(0, 5)], 0.3), ([(4, 4), (4, 5), (7, 2)], 0.3)],
)
def test_a_dead_taxel_gets_nearly_its_value(places, most):
    mask = dead(SENSOR, *places)
    table = repairs(SENSOR, mask)
    assert lost(SENSOR, mask, table) < most
    table[1] += ONE
    assert lost(SENSOR, mask, table) > most


def test_it_is_twice_as_near_as_the_surface_of_least_curvature():
    mask, near = dead(SENSOR, (4, 4)), {1: 8, 9: -2, 11: -2, 10: 8, 2: -1, 20: -1}
    weights = [(44 + sign * step, weight * ONE // 20) for step, weight in near.items() for sign in (1, -1)]
    plate = [HEADER | 44 << PLACE, *(source << PLACE | weight & 0x3FFFF for source, weight in weights)]
    assert lost(SENSOR, mask, repairs(SENSOR, mask)) < lost(SENSOR, mask, np.array(plate)) / 2


def test_mirrored_arrays_have_mirrored_weights():
    (mask, mirrored), codes = (dead(SENSOR, (2, column)) for column in (3, 6)), contacts(SENSOR)
    flipped = codes.reshape(-1, 10, 10)[:, :, ::-1].reshape(codes.shape)
    one, _ = repaired(codes, repairs(SENSOR, mask), BITS)
    other, _ = repaired(flipped, repairs(SENSOR, mirrored), BITS)
    assert np.abs(one[:, 23] - other[:, 26]).max() <= 1


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_a_tenth_of_the_taxels_fits_the_table_and_no_dead_one_is_a_source(sensor):
    mask = np.zeros(sensor.taxels, dtype=bool)
    mask[np.random.default_rng(1).choice(sensor.taxels, -(-sensor.taxels // 10), replace=False)] = True
    table = repairs(sensor, mask.reshape(sensor.rows, sensor.columns))
    numbers, heads = (table & ~HEADER) >> PLACE, table & HEADER > 0
    assert len(table) <= repair_places(sensor.taxels)
    assert numbers[heads].tolist() == np.flatnonzero(mask).tolist()
    assert not mask[numbers[~heads]].any()
    assert (~heads).sum() == mask.sum() * min(SOURCES, repair_places(sensor.taxels) // mask.sum() - 1, (~mask).sum())


def test_many_dead_taxels_share_the_table():
    mask = np.ones((10, 10), dtype=bool)
    mask[::2] = False
    table = repairs(SENSOR, mask)
    assert 450 < len(table) <= repair_places(100)


@pytest.mark.parametrize("size", [(2, 2), (3, 4)])
def test_an_array_that_is_dead_reads_zero(size):
    words = repairs(SensorArray(*size, 4e-3, 2e-3, 3e-3), np.ones(size, dtype=bool))
    assert words.tolist() == [HEADER | taxel << PLACE for taxel in range(size[0] * size[1])]
    codes, largest = repaired(np.full((1, size[0] * size[1]), 99), words, BITS)
    assert not codes.any()
    assert largest.tolist() == [0]


def test_no_dead_taxel_needs_no_word():
    assert len(repairs(SENSOR, dead(SENSOR))) == 0
