"""The stepper: the words of the bit-accurate model in SI units, for one frame at a time."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tfra
from tests.codegen.c.cases import frames
from tfra.stepper import Stepper

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize("example", ["skin_8x12", "learned_fast", "learned_resultant"])
def test_every_value(example: str) -> None:
    sensor = tfra.load(EXAMPLES / f"{example}.toml")
    stress = frames(sensor.project.design, 200) * sensor.adc.lsb
    with warnings.catch_warnings(action="ignore", category=tfra.Notice):
        expected = sensor.estimate(stress, engine="fixed")
    step = sensor.stepper()
    for frame, given in enumerate(stress):
        found = step(given)
        np.testing.assert_array_equal(found.resultant, expected.resultant[frame])
        scalars = expected.phi_deg[frame], expected.mu[frame], expected.status[frame]
        assert (found.phi_deg, found.mu, found.status) == scalars
        if found.forces is None:
            assert expected.resultant_alone
        else:
            np.testing.assert_array_equal(found.forces, expected.forces[frame])


def test_results_and_states_are_their_own() -> None:
    sensor = tfra.load(EXAMPLES / "skin_8x12.toml")
    stress, _ = sensor.simulate()
    step, other = sensor.stepper(), sensor.stepper()
    first = step(stress[0])
    kept = first.resultant.copy()
    other(stress[2])
    step(stress[3].astype(np.float32))
    np.testing.assert_array_equal(first.resultant, kept)


def test_beyond_full_scale() -> None:
    sensor = tfra.load(EXAMPLES / "skin_8x12.toml")
    stress = sensor.simulate()[0][3].copy()
    stress[2, 5] = -3 * sensor.adc.full_scale
    assert sensor.stepper()(stress).status & tfra.Status.INPUT_SATURATED
    assert not sensor.stepper()(np.zeros(sensor.shape)).status & tfra.Status.INPUT_SATURATED


def test_frames_that_are_none() -> None:
    sensor = tfra.load(EXAMPLES / "skin_8x12.toml")
    step = sensor.stepper()
    with pytest.raises(tfra.InputError, match=r"^Stepper: frame: \(8, 12\) is needed, got \(12, 8\)$"):
        step(np.zeros((12, 8)))
    stress = np.zeros(sensor.shape)
    for bad in (np.nan, np.inf):
        stress[3, 4] = bad
        with pytest.raises(tfra.InputError, match=rf"^Stepper: frame: row 3, column 4 is {bad}$"):
            step(stress)


def test_a_design_that_overflows_is_refused() -> None:
    project = tfra.load(EXAMPLES / "fast.toml").project
    fine = replace(project.design.sensor, pitch_x=2e-4, pitch_y=2e-4)
    with pytest.raises(tfra.InputError, match="can overflow"):
        Stepper(replace(project, design=replace(project.design, sensor=fine)))
