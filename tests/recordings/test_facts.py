"""A recording in a few numbers: counts add up, and ranges are those of the frames that have such a value."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Status, Tfra
from tfra.recordings.facts import MEANINGS, RESULTANT_ALONE, Spread, as_dict, facts, lines, status_label

SENSOR = SensorArray(2, 2, 4e-3, 4e-3, 3e-3)


def result(status: list[int], phi_deg: list[float], mu: list[float], force: list[float]) -> Result:
    n, none = len(status), np.zeros(len(status))
    resultant = np.stack([none, none, np.array(force, dtype=float)], axis=1)
    index, angle, friction = np.zeros(n, dtype=np.int64), np.array(phi_deg), np.array(mu)
    return Result(np.zeros((n, 3, 2, 2)), resultant, angle, friction, none, none, index, np.array(status))


FRAMES = np.array(
    [[[-3, 1], [0, 0]], [[-2, 0], [0, 0]], [[0, 2], [0, 0]], [[-4, 1], [1, 0]], [[-1, 1], [0, 0]]], dtype=float
)
FOUND = result([0, 2, 1, 64, 4], [350, 0, 0, 20, 0], [0.5, 0, 0, 0.7, 0.1], [-4, -2, 0, -6, -1])


def test_by_hand() -> None:
    told = facts(FRAMES, FOUND)
    assert (told.frames, told.contact) == (5, 3)
    flags = Status.NO_CONTACT, Status.COMPRESSION_ONLY, Status.NO_DIRECTION, Status.OUTPUT_SATURATED
    assert told.statuses == {flag: int(flag in flags) for flag in Status}
    assert told.phi_deg == Spread(2, 5.0, 350.0, 20.0)
    assert told.mu == Spread(3, 0.5, 0.1, 0.7)
    assert told.force_n == Spread(4, 3.0, 1.0, 6.0)
    assert told.tension_percent_of_taxels == pytest.approx(25)
    assert told.tension_percent_of_stress == pytest.approx(100 * 6 / 16)
    assert told.frames_without_tension == 1
    assert lines(told) == [
        "3 of 5 frames: contact",
        "1: no contact (nothing presses, all results are zero)",
        "1: compression only (no taxel is under traction, so no tangential force can be found)",
        "1 of all: no direction (the tangential force has no direction, phi is set to 0)",
        "1 of all: output saturated (a result exceeded its word length and was saturated)",
        "phi: median 5.0, 350.0 to 20.0 degrees (2 frames)",
        "mu: median 0.500, 0.100 to 0.700 (3 frames)",
        "|F|: median 3, 1 to 6 N (4 frames)",
        "tension: 25.0 % of the taxels, 37.5 % of the stress; 1 frames have none",
    ]
    plain = json.loads(json.dumps(as_dict(told), allow_nan=False))
    assert plain["ranges"]["phi_deg"] == {"frames": 2, "median": 5.0, "min": 350.0, "max": 20.0}
    assert plain["tension"] == {"percent_of_taxels": 25.0, "percent_of_stress": 37.5, "frames_without": 1}


def test_directions_all_around_have_no_median() -> None:
    round_the_clock = [30.0 * n for n in range(12)]
    told = facts(np.ones((12, 2, 2)), result([0] * 12, round_the_clock, [0.5] * 12, [1] * 12))
    assert "phi: all around (12 frames)" in lines(told)


def test_nothing_at_all() -> None:
    told = facts(np.zeros((2, 2, 2)), Tfra(SENSOR)(np.zeros((2, 2, 2))))
    assert (told.statuses[Status.NO_CONTACT], told.contact) == (2, 0)
    assert "phi: in no frame" in lines(told)
    assert as_dict(told)["ranges"] == dict.fromkeys(("phi_deg", "mu", "force_n", "uncertainty_percent"))


def test_the_learned_estimator() -> None:
    """A frame whose F_z is zero has no share, a core may give the resultant alone, and nothing of it is NaN."""
    found = replace(FOUND, uncertainty=np.array([1, 0.5, 0, 3, 0]), threshold=0.25, residual=np.zeros(5))
    assert found.uncertainty_share is not None
    np.testing.assert_array_equal(found.uncertainty_share, [0.25, 0.25, np.nan, 0.5, 0])
    said = "uncertainty: median 25, 0 to 50 % of |F_z| (4 frames); implausible over 25 %, no error bar"
    told = facts(FRAMES, found)
    assert said in lines(told)
    assert RESULTANT_ALONE not in lines(told)
    alone = facts(FRAMES, replace(found, forces=np.full((5, 3, 2, 2), np.nan)))
    assert lines(alone)[lines(alone).index(said) + 1] == RESULTANT_ALONE
    plain = json.loads(json.dumps(as_dict(alone), allow_nan=False))
    assert plain["ranges"]["uncertainty_percent"] == {"frames": 4, "median": 25, "min": 0, "max": 50}
    assert (plain["threshold_percent"], plain["resultant_alone"]) == (25, True)
    assert (as_dict(facts(FRAMES, FOUND))["threshold_percent"], facts(FRAMES, FOUND).resultant_alone) == (None, False)
    empty = replace(FOUND, forces=np.zeros((0, 3, 2, 2)))
    assert not empty.resultant_alone


@given(st.lists(st.integers(0, 127), min_size=1, max_size=40))
@settings(deadline=None)
def test_every_frame_is_counted_once(status: list[int]) -> None:
    """Statuses as the algorithm gives them: a frame without contact has no other kind."""
    status = [bits & ~2 if bits & 1 else bits for bits in status]
    n = len(status)
    told = facts(np.ones((n, 2, 2)), result(status, [1.0] * n, [1.0] * n, [1.0] * n))
    assert told.statuses == {flag: sum(bits & flag != 0 for bits in status) for flag in Status}
    assert told.contact + told.statuses[Status.NO_CONTACT] + told.statuses[Status.COMPRESSION_ONLY] == told.frames == n


@given(st.lists(st.integers(0, 359), min_size=1, max_size=8, unique=True), st.integers(0, 359))
@settings(deadline=None)
def test_the_arc_holds_all_angles_and_turns_with_them(angles: list[int], turn: int) -> None:
    degrees = np.array(angles, dtype=float)
    arc = Spread.of_angles(degrees)
    assert arc is not None
    length = (arc.max - arc.min) % 360
    assert (((degrees - arc.min) % 360) <= length).all()
    assert 0 <= (arc.median - arc.min) % 360 <= length
    assert length <= 360 - 360 / len(angles) + 1e-9  # the largest gap is at least the mean one
    turned = Spread.of_angles((degrees + turn) % 360)
    assert turned is not None
    assert (turned.max - turned.min) % 360 == length


def test_every_status_has_words() -> None:
    assert set(MEANINGS) == set(Status)
    assert status_label(Status.NO_CONTACT) == "no contact"
