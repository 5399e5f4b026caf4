"""Shares of cells against quadrature over the profile, and what must hold whatever the contact."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.cover.cells import cell_shares, taxel_forces
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.scenes import random_contacts
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(7, 9, 4e-3, 2e-3, 3e-3)
SHAPES = list(ContactShape)
reach = st.floats(-1.5, 1.5)


@pytest.mark.parametrize("shape", SHAPES)
def test_gathered_is_the_integral_of_the_density(shape):
    """A cell's midpoints: the density's edge costs no more than the tolerance."""
    edge = np.linspace(0, 1.2, 601)
    middle = (edge[1:] + edge[:-1]) / 2
    cells = shape.density(middle[:, None], middle) * (edge[1] - edge[0]) ** 2
    summed = cells.cumsum(axis=0).cumsum(axis=1)
    np.testing.assert_allclose(shape.gathered(edge[1:, None], edge[1:]), summed, atol=1e-4)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(SHAPES), reach, reach, reach, reach)
def test_loads_of_rectangles_are_not_negative_and_add_up(shape, u0, u1, v0, v1):
    assert shape.gathered(-u0, v0) == -shape.gathered(u0, v0) == shape.gathered(u0, -v0)
    assert shape.gathered(u0, v0) == pytest.approx(shape.gathered(v0, u0), abs=1e-15)
    (u0, u1), (v0, v1) = sorted((u0, u1)), sorted((v0, v1))
    load = np.diff(np.diff(shape.gathered(np.array([[u0], [u1]]), np.array([v0, v1])), axis=0), axis=1).item()
    assert -1e-15 <= load <= 1 + 1e-15


@pytest.mark.parametrize("shape", SHAPES)
def test_corners(shape):
    assert shape.gathered(0, 0) == 0
    np.testing.assert_allclose(shape.gathered([1, 1, 9], [1, 9, 9]), 0.25, rtol=1e-15)
    np.testing.assert_allclose(shape.gathered([1, -1], [1e-9, 0]), [shape.gathered(1e-9, 1), 0], atol=1e-18)


def test_shares_are_those_of_a_fine_quadrature():
    contacts = random_contacts(SENSOR, 12, np.random.default_rng(3))
    fine = 200
    x = (np.arange(SENSOR.columns * fine) + 0.5) / fine * SENSOR.pitch_x - SENSOR.pitch_x / 2
    y = (np.arange(SENSOR.rows * fine) + 0.5) / fine * SENSOR.pitch_y - SENSOR.pitch_y / 2
    area = SENSOR.taxel_area / fine**2
    for contact, shares in zip(contacts, cell_shares(SENSOR, contacts), strict=True):
        pressure = contact.pressure(x, y[:, None]).reshape(SENSOR.rows, fine, SENSOR.columns, fine)
        expected = pressure.sum(axis=(1, 3)) * area / abs(contact.normal_force)
        np.testing.assert_allclose(shares, expected, atol=6e-3 if contact.shape == "uniform" else 1e-4)


def test_shares_of_every_contact_add_up_to_one():
    contacts = random_contacts(SENSOR, 200, np.random.default_rng(4))
    shares = cell_shares(SENSOR, contacts)
    np.testing.assert_allclose(shares.sum(axis=(1, 2)), 1, rtol=1e-13)
    assert (shares >= 0).all()
    shifted = [replace(c, center_x=c.center_x + SENSOR.pitch_x) for c in contacts]  # some reach over the side
    moved = cell_shares(SensorArray(7, 10, 4e-3, 2e-3, 3e-3), shifted)
    np.testing.assert_allclose(moved[:, :, 1:], shares, atol=1e-13)


def test_forces_are_the_load():
    contacts = random_contacts(SENSOR, 20, np.random.default_rng(1))
    forces = taxel_forces(SENSOR, contacts)
    assert forces.shape == (20, 3, 7, 9)
    np.testing.assert_allclose(forces.sum(axis=(2, 3)), [c.force for c in contacts])
    cell = Contact("uniform", 12e-3, 8e-3, 1.9e-3, 0.9e-3, -5, 0.4, 0.7)
    only = taxel_forces(SENSOR, [cell])[0]
    np.testing.assert_allclose(only[:, 4, 3], cell.force)
    assert np.count_nonzero(only) == 3
    assert cell_shares(SENSOR, []).shape == (0, 7, 9)
