"""The finer residual, and the scenes that it is tried on."""

from __future__ import annotations

import numpy as np

from bench.learned import plausibility
from bench.learned.plausibility import JUDGES, QUIET, TWO, curve, distance, fine_influence, fine_residual, scenes, table
from tfra.model.cover.scenes import any_contacts
from tfra.model.learned.field import influence
from tfra.model.sensor import SensorArray

SENSOR = SensorArray(4, 5, 4e-3, 3e-3, 3e-3)


def test_parts_of_a_cell_add_up_to_it() -> None:
    whole = influence(SENSOR)
    for fine, coarse in zip(fine_influence(SENSOR), (whole.x, whole.y, whole.z), strict=True):
        parts = fine.reshape(SENSOR.taxels, SENSOR.rows, plausibility.SPLIT, SENSOR.columns, plausibility.SPLIT)
        assert np.allclose(parts.mean(axis=(2, 4)).reshape(SENSOR.taxels, -1), coarse, rtol=1e-9, atol=1e-9)


def test_what_its_model_explains_leaves_nothing() -> None:
    rng = np.random.default_rng(0)
    x, y, z = fine_influence(SENSOR)
    p, mu_x, mu_y = rng.uniform(0, 1, (3, x.shape[1])), rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    b = (mu_x[:, None] * (p @ x.T) + mu_y[:, None] * (p @ y.T) - p @ z.T).reshape(3, SENSOR.rows, SENSOR.columns)
    assert (fine_residual(SENSOR, b, mu_x, mu_y) < 1e-8).all()
    assert (fine_residual(SENSOR, -b, mu_x, mu_y) > 0.1).all()


def test_scenes_have_a_force_for_each_frame() -> None:
    rng, sensor = np.random.default_rng(1), SensorArray(8, 9, 4e-3, 3e-3, 3e-3)
    found = dict(scenes(sensor, any_contacts(sensor, 40, rng), rng))
    assert next(iter(found)) == QUIET
    for name, scene in found.items():
        assert scene.stress.shape == (len(scene.force), 8, 9), name
        assert np.isfinite(scene.stress).all(), name
    assert 0 < len(found["two contacts, more than 4 pitches apart"].force) < 40
    quiet = found[QUIET].stress
    assert ((found["a taxel dead"].stress != quiet).sum(axis=(1, 2)) == 1).all()


def test_the_curve_counts_what_is_over_the_quantile() -> None:
    single, twice = np.arange(100.0), np.array([0.0, 97.0, 98.5, 1000.0])
    found = curve({QUIET: dict.fromkeys(JUDGES, single), TWO: dict.fromkeys(JUDGES, twice)})
    assert found["2"] == dict.fromkeys(JUDGES, 50.0)
    assert found["1"] == dict.fromkeys(JUDGES, 50.0)
    assert found["5"] == dict.fromkeys(JUDGES, 75.0)
    assert list(found) == ["1", "2", "5", "10", "20"]


def test_the_table() -> None:
    judged = {judge: {"percent": [3 + i, 4], "flagged": 7.0 + i, "if_wide": None} for i, judge in enumerate(JUDGES)}
    judged[JUDGES[0]]["if_wide"] = 9.0
    told = table(
        {QUIET: {"force_percent": [1, 2], "wide": 0.5} | judged},
        {
            "thresholds": dict.fromkeys(JUDGES, 0.1),
            "curve": {"2": dict.fromkeys(JUDGES, 30.0)},
            "field_percent": {"TFRA": [30, 60]},
        },
    )
    assert f"| {QUIET} | 1.0 / 2.0 | 3.0 / 4.0 | 7 % | 4.0 / 4.0 | 8 % | 5.0 / 4.0 | 9 % | 9 %, –, – |" in told
    assert "Thresholds: uncertainty 10 %, residual 10 %, finer residual 10 %.\n" in told
    assert f"Error of the forces at the taxels, {QUIET}: TFRA 30.0 / 60.0 %.\n" in told
    assert told.endswith("| 2 % | 30 % | 30 % | 30 % |")
    assert distance(np.ones((1, 3, 2, 2)), np.full((1, 3, 2, 2), 2.0)) == [0.5]
