"""The map of TFRA's friction, and every estimator by its name."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.accuracy import estimators as module
from bench.accuracy.estimators import FIXED, LEARNED, NAMES, TFRA, Mapped, estimators
from tests.bench.accuracy.random_case import SENSOR, random_case
from tfra.model.arrays import Floats
from tfra.model.cover.scenes import contact_codes
from tfra.model.tfra import Tfra


def fake(mu: Floats, phi: Floats) -> Any:
    """TFRA that finds ``mu`` and ``phi`` whatever it sees."""

    class Fake:
        sensor = SENSOR

        def __call__(self, stress: Floats) -> Any:
            return SimpleNamespace(mu=mu, phi_deg=phi)

    return Fake()


def loads(mu: Floats) -> Floats:
    return np.stack([np.zeros(len(mu)), 2 * mu, np.full(len(mu), -2.0)], axis=1)


def test_the_map_is_the_nearest_that_never_falls() -> None:
    found, true = np.array([0.5, 0.0, 0.0, 1.0, 0.8]), np.array([0.6, 0.1, 0.3, 0.9, 0.4])
    fitted = Mapped.fitted(fake(found, found), np.zeros((5, 4, 5)), loads(true))
    assert fitted.found.tolist() == [0.0, 0.5, 0.8, 1.0]
    assert fitted.true == pytest.approx([0.2, 0.5, 0.5, 0.9])  # the mean of ties, and of two that fall


def test_a_mapped_resultant_has_the_sum_of_the_stress() -> None:
    stress = np.full((2, 4, 5), -100.0)
    mapped = Mapped(fake(np.array([0.25, 9.0]), np.array([0.0, 90.0])), np.array([0.0, 0.5]), np.array([0.1, 0.3]))
    normal = -100.0 * SENSOR.size_x * SENSOR.size_y
    expected = [[-0.2 * normal, 0, normal], [0, -0.3 * normal, normal]]
    assert mapped(stress).resultant == pytest.approx(np.array(expected))
    assert mapped(stress).mu == pytest.approx([0.2, 0.3])


def test_every_estimator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "FITTED", 50)
    case = random_case()
    codes = contact_codes(case.design, 8, 5)
    every = estimators(case)
    assert tuple(every) == NAMES
    found = {name: estimate(codes) for name, estimate in every.items()}
    assert all(result.resultant.shape == (8, 3) for result in found.values())
    direct = Tfra.of(case.design)(codes * case.design.adc.lsb)
    assert np.array_equal(found[TFRA].resultant, direct.resultant)
    exact, scale = found[LEARNED].resultant, np.abs(found[LEARNED].resultant).max()
    assert 0 < np.abs(found[FIXED].resultant - exact).max() < 1e-3 * scale
