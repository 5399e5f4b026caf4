"""Forces at the taxels, and the part of a frame that they explain."""

import numpy as np
import pytest

from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts, taxel_forces
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.learned.field import influence, residual, spread
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra

ODD = SensorArray(4, 3, 5e-3, 3e-3, 2e-3)


def loads(sensor: SensorArray, force: Floats) -> Contacts:
    """``force (m, 3)`` on the cell of each taxel alone."""
    half = np.tile([sensor.pitch_x / 2, sensor.pitch_y / 2], (sensor.taxels, 1))
    return Contacts(np.full(sensor.taxels, "uniform"), np.stack(sensor.positions(), axis=1), half, force)


@pytest.mark.parametrize("sensor", [ODD, SENSORS["8×8, 2×2 mm, h 3 mm"]], ids=str)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_influence_is_the_frame_of_a_unit_load(sensor: SensorArray, axis: int) -> None:
    expected = frames(sensor, loads(sensor, np.eye(3)[[axis] * sensor.taxels])).reshape(sensor.taxels, -1).T
    g = influence(sensor)
    assert np.abs((g.x, g.y, g.z)[axis] - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.allclose(g.inverse @ g.z, np.eye(sensor.taxels), atol=1e-11)


def test_forces_of_cells_are_explained_and_found() -> None:
    """Without friction, even loads of cells are the model itself."""
    rng = np.random.default_rng(0)
    sensor = SENSORS["5×7, 3×3 mm, h 2 mm"]
    true = np.zeros((4, 3, sensor.taxels))
    true[:, 2] = -rng.uniform(0.1, 1, size=true[:, 2].shape)
    b = true[:, 2] @ influence(sensor).z.T
    found = spread(sensor, b, true.sum(axis=2))
    assert np.allclose(found, true, atol=1e-12)
    assert (residual(sensor, b, found) < 1e-12).all()


def test_without_compression_the_field_is_uniform() -> None:
    b = -np.sum(influence(ODD).z, axis=1)[None]  # p = 1 at every taxel, and its opposite
    assert np.allclose(spread(ODD, -b, np.array([[1.0, 2.0, -3.0]])), np.array([1, 2, -3])[None, :, None] / ODD.taxels)


def test_no_stress_is_explained() -> None:
    nothing = np.zeros((1, ODD.taxels))
    assert residual(ODD, nothing, np.zeros((1, 3, ODD.taxels))) == [0.0]
    assert residual(ODD, nothing + 1, np.zeros((1, 3, ODD.taxels))) == [1.0]


def test_the_field_of_contacts_is_nearer_than_that_of_tfra() -> None:
    sensor = SENSORS["10×10, 4×4 mm, h 3 mm"]
    contacts = random_contacts(sensor, 60, np.random.default_rng(2))
    b, true = frames(sensor, contacts), taxel_forces(sensor, contacts).reshape(60, 3, -1)
    found = spread(sensor, b.reshape(60, -1), true.sum(axis=2))

    def error(forces: Floats) -> float:
        return float(np.median(np.linalg.norm(forces - true, axis=(1, 2)) / np.linalg.norm(true, axis=(1, 2))))

    assert error(found) < 0.5 * error(Tfra(sensor)(b).forces.reshape(60, 3, -1))
    wrong = found * [[1.0], [-1.0], [1.0]]
    assert (residual(sensor, b.reshape(60, -1), wrong) > residual(sensor, b.reshape(60, -1), found)).mean() > 0.9
