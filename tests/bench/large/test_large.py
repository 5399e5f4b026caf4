"""The study of large arrays: its counts by hand, its measure, and every way on a small array."""

from dataclasses import replace

import numpy as np
import pytest

from bench.large import large
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Dense, Operators, Tfra

SENSOR = SensorArray(8, 8, 4e-3, 4e-3, 3e-3)


@pytest.fixture(scope="module", name="exact")
def _exact():
    return Tfra(SENSOR)(frames(SENSOR, random_contacts(SENSOR, 40, np.random.default_rng(2))))


def test_convolutions_by_hand():
    assert large.convolutions(1) == 3 + 1 + 2 * (6 + 2) + 6 + 3
    # 256 points: 2,048 products a transform, 512 a spectrum
    assert large.transforms(SENSOR, 0) == 16 * 2048 + 10 * 512
    assert large.transforms(SENSOR, 1) - large.transforms(SENSOR, 0) == 26 * 2048 + 19 * 512


def test_agreement_notices_wrong_results(exact):
    whole = slice(None)
    same = large.agreement(exact, exact, whole)
    assert (same["equal"], same["one_step"], same["force_worst"], same["mu"]) == (1, 1, 0, 0)
    frame = int(np.flatnonzero(exact.status == 0)[0])
    index, mu = exact.sweep_index.copy(), exact.mu.copy()
    index[frame] += 2
    mu[frame] += 0.25
    wrong = large.agreement(replace(exact, sweep_index=index, mu=mu), exact, whole)
    assert wrong["equal"] == wrong["one_step"] == pytest.approx(1 - 1 / same["swept"])
    assert wrong["mu"] == pytest.approx(0.25)
    part = slice(0, 10)
    first = replace(exact, **{key: getattr(exact, key)[part] for key in vars(exact) if getattr(exact, key) is not None})
    assert large.agreement(first, exact, part)["equal"] == 1


def test_windows_as_wide_as_the_array_are_dense():
    x = np.random.default_rng(1).normal(size=(3, SENSOR.taxels))
    dense = Dense(large.operators(SENSOR))
    wide, narrow = large.Windowed(SENSOR, 7), large.Windowed(SENSOR, 2)
    np.testing.assert_allclose(wide.normal(x), dense.normal(x), atol=1e-12)
    np.testing.assert_allclose(wide.solve(x), dense.solve(x), atol=1e-12 * np.abs(dense.solve(x)).max())
    assert not np.allclose(narrow.normal(x), dense.normal(x), atol=1e-3)
    one = np.zeros((1, SENSOR.taxels))
    one[0, 0] = 1
    seen = narrow.solve(one).reshape(8, 8) != 0
    assert seen[:3, :3].all()
    assert not seen[3:].any()
    assert isinstance(large.operators(SENSOR), Operators)


def test_every_way_is_measured():
    result = large.study(SENSOR, 40)
    families = {row["family"] for row in result["rows"]}
    assert families == set(large.STYLES)
    best = {f: max(row["equal"] for row in result["rows"] if row["family"] == f) for f in families}
    assert best["separable"] == best["conjugate gradients"] == 1
    assert all(row["phi_deg"] < 1e-9 for row in result["rows"])  # the centroids need no operator
    results = {"8×8, 4 mm": result}
    assert len({line.count("|") for line in large.table(results).splitlines()}) == 1
    assert len({line.count("|") for line in large.term_table(results).splitlines()}) == 1


def test_budgets_by_hand(monkeypatch):
    monkeypatch.setattr(large, "BUDGETS", (("8×8, 4 mm", 1e-3, 10, 1e6), ("9×9, 4 mm", 1e-3, 10, 1e6)))
    terms = dict.fromkeys(("c33_inv", "c31", "c32", "c33", "normal"), 2) | {"gram": 5}
    row = {"family": "separable", "strength": 1e-3, "products": 9500, "words": 2049}
    lines = large.budget_table({"8×8, 4 mm": {"terms": {"0.001": terms}, "rows": [row]}}).splitlines()
    assert len(lines) == 3
    # 9 x 2 + 5 terms; 950 cycles and 5 %; 704 vector words of two; 2 x 8 x 8 x 5 words of Z
    assert lines[2] == "| 8×8, 4 mm | 0.001 | 23 | 9,500 | 10, 1 MHz | 1,000 | 1,000 | 3 + 2 + 1 = 6 |"


def test_rectangular_arrays_too():
    rows = large.study(SENSORS["5×7, 3×3 mm, h 2 mm"], 20)["rows"]
    assert all(row["products"] > 0 < row["words"] for row in rows)
