"""Contacts and their shares of taxels against numeric quadrature and the paper's resultants."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy import special

from tfra.model.cover.contact import Contact, ContactShape, cell_shares, taxel_forces
from tfra.model.cover.scenes import random_contacts
from tfra.model.sensor import SensorArray

Floats = npt.NDArray[np.float64]

SENSOR = SensorArray(7, 9, 4e-3, 2e-3, 3e-3)
SHAPES = list(ContactShape)
reach = st.floats(-1.5, 1.5)


def contact(shape: ContactShape = ContactShape.HERTZ, /, **changes: float) -> Contact:
    values: dict[str, float] = {
        "center_x": 18e-3,
        "center_y": 9e-3,
        "half_x": 8e-3,
        "half_y": 4e-3,
        "normal_force": -5.73,
        "mu": 0.5,
        "phi": math.radians(30),
    }
    return Contact(shape, **(values | changes))


def integrate(load: Contact, function: Callable[[Floats, Floats], Floats], order: int = 80) -> float:
    """Integral of ``function(x, y)`` over the footprint by Gauss quadrature.

    x = half sin(t) takes the square root out of the edges; for the ellipse y follows the chord at x.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    t, w = nodes * math.pi / 2, weights * math.pi / 2
    u, du = np.sin(t)[:, None], (w * np.cos(t))[:, None]
    chord = np.sqrt(1 - u * u) if load.shape is ContactShape.HERTZ else np.ones_like(u)
    v, dv = chord * np.sin(t), chord * w * np.cos(t)
    values = function(load.center_x + load.half_x * u, load.center_y + load.half_y * v)
    return float(np.sum(values * du * dv) * load.half_x * load.half_y)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("k", [(0, 0), (90, 0), (0, 250), (400, 300), (1500, -800)])
def test_profile_is_the_transform_of_the_pressure(shape: ContactShape, k: tuple[float, float]) -> None:
    load, (kx, ky) = contact(shape), k

    def integrand(x: Floats, y: Floats) -> Floats:
        phase = np.cos(kx * (x - load.center_x)) * np.cos(ky * (y - load.center_y))
        return np.asarray(load.pressure(x, y) / 5.73 * phase)

    transform = shape.transform(kx * load.half_x, ky * load.half_y)
    assert transform == pytest.approx(integrate(load, integrand), abs=1e-10)


@pytest.mark.parametrize("shape", SHAPES)
def test_pressure_has_its_footprint(shape: ContactShape) -> None:
    load = contact(shape)
    corner = load.pressure(18e-3 + 7e-3, 9e-3 + 3.5e-3)
    assert (corner == 0) == (shape is ContactShape.HERTZ)
    for x, y in ((26.01e-3, 9e-3), (9.99e-3, 9e-3), (18e-3, 13.01e-3), (18e-3, 4.99e-3)):
        assert load.pressure(x, y) == 0
    assert load.pressure(25.9e-3, 9e-3) > 0
    assert load.pressure(18e-3, 12.9e-3) > 0


def test_hertz_transform_has_no_seam_at_small_arguments() -> None:
    s = np.concatenate([[0.0], np.geomspace(1e-9, 60, 4000), np.nextafter(0.5, [0, 1])])
    with np.errstate(all="raise", under="ignore"):
        ours = ContactShape.HERTZ.transform(s * 0.6, s * 0.8)
    expected = np.ones_like(s)
    expected[1:] = 3 * special.spherical_jn(1, s[1:]) / s[1:]
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-14)


@given(st.sampled_from(SHAPES), st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
@example(ContactShape.ROUNDED, 0.0, 2.1e-308)
def test_transform_is_bounded_and_even(shape: ContactShape, s_x: float, s_y: float) -> None:
    value = shape.transform(s_x, s_y)
    assert abs(value) <= 1 + 1e-14
    for other in (shape.transform(-s_x, s_y), shape.transform(s_x, -s_y)):
        assert other == value


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [(0, (2.865, 0)), (45, (2.026, 2.026)), (90, (0, 2.865)), (180, (-2.865, 0)), (270, (0, -2.865))],
)
def test_force_has_the_signs_of_the_tables(degrees: float, expected: tuple[float, float]) -> None:
    force = contact(phi=math.radians(degrees)).force
    assert force == pytest.approx((*expected, -5.73), abs=1e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_tractions_integrate_to_the_force(shape: ContactShape) -> None:
    load = contact(shape, phi=2.0)
    total = [integrate(load, lambda x, y, i=i: load.tractions(x, y)[i]) for i in range(3)]
    assert total == pytest.approx(load.force, rel=1e-9)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("center_x", math.nan),
        ("center_y", math.inf),
        ("half_x", 0.0),
        ("half_y", -1e-3),
        ("half_x", math.inf),
        ("normal_force", 0.0),
        ("normal_force", 1.0),
        ("normal_force", -math.inf),
        ("normal_force", math.nan),
        ("mu", -0.1),
        ("mu", math.inf),
        ("phi", math.nan),
    ],
)
def test_bad_values_name_the_field(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{field}:"):
        contact(**{field: value})


def test_shape_may_be_named() -> None:
    assert contact("rounded").shape is ContactShape.ROUNDED
    with pytest.raises(ValueError, match=r"^shape: one of hertz, uniform, rounded"):
        contact("round")


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
