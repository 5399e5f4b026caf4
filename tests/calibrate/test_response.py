"""Stress of presses against the exact series, and derivatives against difference quotients."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0

from tfra.calibrate.response import Presses, Response
from tfra.model.arrays import Floats
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import ElasticLayer
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(9, 7, 3e-3, 2.5e-3, 3e-3)
PRESSES = Presses(
    x=np.array([6e-3, 10e-3]),
    y=np.array([8e-3, 12e-3]),
    log_radius=np.log([3e-3, 2e-3]),
    force=np.array([[1.0, 2.0, -5.0], [-0.5, 0.3, -2.0]]),
    flat=np.array([False, False]),
)
LAYER = math.log(3.3e-3), 0.47


def stress(response: Response, presses: Presses, layer: tuple[float, float] = LAYER) -> Floats:
    return response(*layer, presses).value


@pytest.mark.parametrize("margin", [0.0, 9e-3])
def test_balls_press_as_in_the_exact_series(margin: float) -> None:
    layer = ElasticLayer.under(SENSOR, LAYER[1], math.exp(LAYER[0]), margin)
    radius = np.exp(PRESSES.log_radius)
    places, half = np.stack([PRESSES.x, PRESSES.y], axis=1), np.stack([radius, radius], axis=1)
    contacts = Contacts(np.array(["hertz", "hertz"]), places, half, PRESSES.force)
    columns, rows = np.arange(SENSOR.columns) * SENSOR.pitch_x, np.arange(SENSOR.rows) * SENSOR.pitch_y
    exact = layer.base_stress(contacts, columns, rows).reshape(2, -1)
    np.testing.assert_allclose(stress(Response(SENSOR, margin), PRESSES), exact, atol=1e-5 * np.abs(exact).max())


def test_a_flat_punch_has_the_pressure_of_boussinesq() -> None:
    """1 / (2 pi a^2 sqrt(1 - r^2)) integrated under the layer's own response to a point: far away both agree."""
    punch = PRESSES._replace(flat=np.array([True, True]))
    found = -stress(Response(SENSOR, 9e-3), punch._replace(force=np.array([[0.0, 0.0, -1.0]] * 2)))[0]
    x, y = SENSOR.positions()
    layer = ElasticLayer.under(SENSOR, LAYER[1], math.exp(LAYER[0]))
    for taxel in (3 * SENSOR.columns + 2, 4 * SENSOR.columns + 3):
        distance, radius = math.hypot(x[taxel] - PRESSES.x[0], y[taxel] - PRESSES.y[0]), 3e-3

        def integrand(k: float, distance: float = distance, radius: float = radius) -> float:
            return k * j0(k * distance) * math.sin(k * radius) / (k * radius) * float(layer.transfer(k)[0])

        exact = quad(integrand, 1e-6, 12e3, limit=500)[0] / (2 * math.pi)
        assert found[taxel] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("name", ["x", "y", "log_radius"])
def test_derivatives_of_presses(name: str) -> None:
    response, step = Response(SENSOR, 0.0), 1e-7
    more, less = (PRESSES._replace(**{name: getattr(PRESSES, name) + way * step}) for way in (1, -1))
    quotient = (stress(response, more) - stress(response, less)) / (2 * step)
    derivative = getattr(response(*LAYER, PRESSES), name)
    np.testing.assert_allclose(derivative, quotient, atol=1e-5 * np.abs(quotient).max())


@pytest.mark.parametrize(("name", "step"), [("log_thickness", (1e-4, 0.0)), ("poisson", (0.0, 1e-4))])
def test_derivatives_of_the_layer(name: str, step: tuple[float, float]) -> None:
    response = Response(SENSOR, 0.0)
    more, less = ((LAYER[0] + way * step[0], LAYER[1] + way * step[1]) for way in (1, -1))
    quotient = (stress(response, PRESSES, more) - stress(response, PRESSES, less)) / (2 * sum(step))
    derivative = getattr(response(*LAYER, PRESSES), name)
    np.testing.assert_allclose(derivative, quotient, atol=1e-3 * np.abs(quotient).max())


def test_stress_is_linear_in_the_force() -> None:
    response = Response(replace(SENSOR, rows=4), 0.0)
    found = response(*LAYER, PRESSES)
    parts = np.einsum("nk,knm->nm", PRESSES.force, found.force)
    np.testing.assert_allclose(found.value, parts, rtol=1e-12, atol=1e-9)
