"""Contacts against numeric quadrature, special-function tables and the paper's resultants."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import special

from tfra.model.cover.contact import Contact, ContactShape

Floats = npt.NDArray[np.float64]

SHAPES = list(ContactShape)


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
