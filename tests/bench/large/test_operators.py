"""The study of stored operators counts what the model has, and its measure notices a wrong result."""

from dataclasses import replace

import numpy as np
import pytest

from bench.large import operators
from tests.model.cases import make_design
from tfra.hdl.parallel.matvec.images import lane_images
from tfra.hdl.parallel.matvec.unit import MatVec
from tfra.hdl.parallel.tfra.core import Core
from tfra.model.cover.scenes import SENSORS, contact_codes
from tfra.model.tfra import Tfra

SENSOR = SENSORS["5×7, 3×3 mm, h 2 mm"]


def test_budget_of_pinv_is_the_gatewares():
    design = make_design(SENSOR)
    found = operators.budget(design, "pinv")
    lanes, depth = lane_images(design).shape
    assert (found["depth"], found["products"]) == (depth, MatVec(design).multiplications)
    assert found["blocks"] == lanes * -(-depth // operators.BLOCK)


def test_forms_trade_memory_for_time():
    design = make_design(SENSOR)
    forms = [replace(design, operators=form) for form in ("pinv", "gram", "gram")]
    budgets = [operators.budget(d, form) for d, form in zip(forms, operators.FORMS, strict=True)]
    for key, sign in (("bits", -1), ("depth", -1), ("products", 1), ("busy", 1)):
        values = [sign * budget[key] for budget in budgets]
        assert values == sorted(set(values)), key
    later = [operators.added_latency(d, form) for d, form in zip(forms, operators.FORMS, strict=True)]
    assert 0 == later[0] < later[1] < later[2]


def test_agreement_notices_a_wrong_winner_and_a_wrong_force():
    design = make_design(SENSOR)
    exact = Tfra(SENSOR)(contact_codes(design, 30, 1) * design.adc.lsb)
    same = operators.agreement(design, exact, exact)
    assert (same["equal"], same["force"], same["largest_step"]) == (same["swept"], 0, 0)
    frame = int(np.flatnonzero(exact.status == 0)[0])
    index, forces = exact.sweep_index.copy(), exact.forces.copy()
    index[frame] += 3
    wrong = operators.agreement(design, replace(exact, sweep_index=index), exact)
    assert (wrong["equal"], wrong["largest_step"]) == (same["swept"] - 1, 3)
    forces[frame, 1, 2, 3] += 0.01 * np.linalg.norm(exact.resultant[frame])
    assert operators.agreement(design, replace(exact, forces=forces), exact)["force"] == pytest.approx(0.01)


def test_every_form_is_measured():
    rows = operators.measure(SENSOR, 60)
    assert set(rows) == set(operators.FORMS)
    assert all(row["equal"] >= 0.95 * row["swept"] > 10 and row["force"] < 1e-4 for row in rows.values())
    lines = operators.table({"x": rows}).splitlines()
    assert len({line.count("|") for line in lines}) == 1


def test_the_core_refuses_what_it_cannot_multiply_by():
    with pytest.raises(ValueError, match=r"^operators: .*pinv"):
        Core(replace(make_design(SENSOR), operators="gram"))
