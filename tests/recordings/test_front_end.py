"""The front end of the host: codes are the words of the core's, other numbers are right, drift is followed."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.fixed import front_end as core
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra
from tfra.recordings.calibration import Calibration, read_calibration
from tfra.recordings.diagnosis import warnings
from tfra.recordings.frames import read_recording
from tfra.recordings.front_end import Array, FrontEnd
from tfra.recordings.input import PLAIN, Input, overridden
from tfra.recordings.intake import Intake, averaged
from tfra.recordings.levels import doubts
from tfra.runtime.errors import InputError

SENSOR = SensorArray(4, 5, 3e-3, 3e-3, 2.5e-3)
BITS = 12
ADC = Adc(BITS, 204800.0)  # 100 Pa a code
ARRAY = Array(SENSOR, ADC)
DESIGN = TfraDesign(SENSOR, adc=ADC)


@settings(max_examples=40, deadline=None)
@given(
    coding=st.sampled_from(["signed", "offset", "unipolar"]),
    compression=st.sampled_from(["negative", "positive"]),
    pa_per_code=st.sampled_from([None, 33.3, 100.0, 250.0]),
    dead=st.sampled_from([(), ((0, 0),), ((1, 2), (3, 4), (2, 2))]),
    spread=st.sampled_from([0.0, 0.3]),
    log2_tare=st.integers(0, 6),
    log2_average=st.integers(0, 6),
    seed=st.integers(0, 1000),
)
def test_codes_are_the_words_of_the_core(
    seed: int, log2_tare: int, log2_average: int, spread: float, **how: Any
) -> None:
    """With its registers and tables as stated, its own tare and its means; one that is not complete is none."""
    rng, words = np.random.default_rng(seed), Input(unit="codes", average=1 << log2_average, **how)
    low = -(1 << (BITS - 1)) if words.coding == "signed" else 0
    count = (7 << log2_average) + 1 + (1 << log2_tare)
    raw = rng.integers(low, low + (1 << BITS), (count, SENSOR.rows, SENSOR.columns))
    rest = raw[: 1 << log2_tare]
    rest[:] = low + rng.integers(1 << 8, size=raw.shape[1:]) + rng.integers(20, size=rest.shape)
    gain = rng.uniform(1 - spread, 1 + spread, (SENSOR.rows, SENSOR.columns))
    host = FrontEnd(ARRAY, words, rest.astype(np.float64), replace(Calibration.none(SENSOR), gain=gain))
    unit = core.FrontEnd(DESIGN, replace(host.settings, log2_tare=log2_tare), core.Tables.of(SENSOR.taxels))
    unit.tables = replace(unit.tables, gains=host.tables.gains, repairs=host.tables.repairs)
    unit.tare()
    cleaned = unit(raw & 0xFFFF)
    assert unit.tables.offsets.tolist() == host.tables.offsets.tolist()
    stress = host(averaged(raw[1 << log2_tare :].astype(np.float64), words.average))
    assert len(stress) == 7 + (log2_average == 0)
    assert (stress == cleaned.codes * ADC.lsb).all()


@settings(max_examples=40, deadline=None)
@given(
    average=st.sampled_from([1, 2, 4]),
    tare_frames=st.integers(0, 5),
    drift_frames=st.sampled_from([0, 3]),
    cuts=st.lists(st.integers(0, 40), max_size=6),
    seed=st.integers(0, 1000),
)
def test_frames_that_come_in_any_parts_are_those_of_the_whole(cuts: list[int], seed: int, **how: Any) -> None:
    rng, words = np.random.default_rng(seed), Input(unit="codes", coding="offset", **how)
    raw = rng.integers(1000, 1200, (40, SENSOR.rows, SENSOR.columns)).astype(np.float64)
    means = raw[: 40 // words.average * words.average].reshape(-1, words.average, *raw.shape[1:]).mean(axis=1)
    rest, shown = means[: words.tare_frames], means[words.tare_frames :]
    expected = FrontEnd(ARRAY, words, rest if len(rest) else None)(shown)
    intake = Intake(FrontEnd(ARRAY, words), ADC, words)
    found = np.concatenate([intake(part) for part in np.split(raw, sorted(cuts))])
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("unit", ["Pa", "kPa", "codes"])
def test_other_numbers_are_within_their_rounding(unit: str) -> None:
    """The same stress in each unit, by its definition in doubles."""
    rng, factor = np.random.default_rng(1), {"Pa": 1.0, "kPa": 1e3, "codes": 100.0}[unit]
    truth = 100.0 * rng.integers(-1000, 1000, (6, SENSOR.rows, SENSOR.columns))
    offset = 100.0 * rng.integers(0, 50, (SENSOR.rows, SENSOR.columns))
    host = FrontEnd(ARRAY, Input(unit=unit, dead=((2, 2),)), offset[None] / factor)  # type: ignore[arg-type]
    stress = host((truth + offset) / factor)
    alive = np.ones((SENSOR.rows, SENSOR.columns), dtype=bool)
    alive[2, 2] = False
    assert stress[:, alive] == pytest.approx(truth[:, alive], rel=1e-12)


def followed(levels: Floats, offset: Floats, least: float, frames_: int) -> Floats:
    """The offset of each frame, one frame after the other."""
    offset, found = offset.astype(np.float64), []
    for level in levels:
        found.append(offset)
        if np.abs(level - offset).max() < least:
            offset = offset + (level - offset) / frames_
    return np.array(found)


@pytest.mark.parametrize("parts", [1, 7])
@pytest.mark.parametrize("seed", range(4))
def test_the_offset_follows_between_contacts(seed: int, parts: int) -> None:
    """Whether frames come one by one or all at once; contacts of all lengths."""
    rng, given = np.random.default_rng(seed), Input(drift_frames=20)
    count, least = 400, ADC.threshold * ADC.lsb
    drift = np.linspace(0, 30 * least, count)[:, None, None] * rng.uniform(-1, 1, (4, 5)) * (seed < 3) / 40
    pressed = np.repeat(rng.random(count // 4) < 0.3, 4) if seed % 2 else rng.random(count) < 0.5
    pressed[0] = False
    levels = drift + 0.05 * least * rng.normal(size=(count, 4, 5))
    levels[pressed, 1, 1] -= 5 * least
    host = FrontEnd(ARRAY, given, levels[:1])
    found = np.concatenate([host(part) for part in np.array_split(levels, parts)])
    expected = levels - followed(levels, levels[0], least, 20)
    assert found == pytest.approx(expected, abs=1e-9 * least)
    still = ~pressed[200:]
    assert np.abs(found[200:][still]).max() < 0.6 * least


@pytest.mark.parametrize(("step", "ends"), [(31.0, 0.0), (33.0, -1650.0)])
def test_what_moves_the_offset_is_less_than_a_contact(step: float, ends: float) -> None:
    """A contact is 16 codes of 100 Pa or more, so 32 of 50 Pa."""
    given = Input(unit="codes", pa_per_code=50.0, drift_frames=5)
    levels = np.zeros((200, 4, 5))
    levels[1:, 2, 2] = -step
    found = FrontEnd(ARRAY, given)(levels)
    assert found[-1, 2, 2] == pytest.approx(ends, abs=51)


def test_a_real_sensor_is_nearly_as_good_as_a_perfect_one() -> None:
    """9 x 7 taxels of an inverted, unsigned converter at rest at about 600 of 4,095, one of them dead, with drift."""
    sensor, rng = SensorArray(9, 7, 4e-3, 4e-3, 3e-3), np.random.default_rng(2)
    contacts = random_contacts(sensor, 60, rng)
    exact = frames(sensor, contacts)
    exact *= (120e3 / np.abs(exact).max(axis=(1, 2)))[:, None, None]
    stress = np.zeros((60 * 20, 9, 7))
    stress[19::20] = exact  # nineteen frames at rest before each
    noise = 0.3e-3 * 200e3 * rng.normal(size=stress.shape)
    offsets = rng.uniform(-40, 40, (9, 7)) + np.linspace(0, 60, len(stress))[:, None, None] * rng.uniform(-1, 1, (9, 7))
    words = np.clip(np.rint(600 + offsets - (stress + noise) / 60.0), 0, 4095)
    words[:, 3, 4] = 17
    array = Array(sensor, Adc(13, 60.0 * 4096))
    given = Input(unit="codes", coding="unipolar", compression="positive", pa_per_code=60.0, dead=((3, 4),))
    tfra, pressed = Tfra(sensor), slice(19, None, 20)
    truth = tfra(exact).resultant

    def error(stress: Floats) -> float:
        found = tfra(stress[pressed]).resultant
        return float(np.median(np.linalg.norm(found - truth, axis=1) / np.linalg.norm(truth, axis=1)))

    perfect = error(stress + noise)
    assert error(FrontEnd(array, replace(given, dead=()), words[:16])(words)) > 8 * perfect
    assert error(FrontEnd(array, given, words[:16])(words)) > 2 * perfect
    assert error(FrontEnd(array, replace(given, drift_frames=20), words[:16])(words)) < 2.2 * perfect


TABLES = """form = "tfra-calibration-1"
gain = [[1.0, 1.1, 0.9, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, 2]]
rest = [[10, 11, 12, 13, 14], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, -5]]
dead = [[1, 2]]
"""


@pytest.mark.parametrize("unit", ["Pa", "codes"])
def test_a_calibration_is_of_each_taxel(tmp_path: Path, unit: str) -> None:
    """Its gains and numbers at rest; a tare or a code at rest replaces these."""
    (tmp_path / "cal.toml").write_text(TABLES)
    known = read_calibration(tmp_path / "cal.toml", SENSOR)
    levels, factor = np.full((1, 4, 5), 60.0), 1.0 if unit == "Pa" else ADC.lsb
    found = FrontEnd(ARRAY, Input(unit=unit), None, known)(levels)[0] / factor  # type: ignore[arg-type]
    expected = {(0, 0): 50, (0, 1): 1.1 * 49, (0, 2): 0.9 * 48, (1, 0): 60, (3, 4): 130}
    for place, value in expected.items():
        assert found[place] == pytest.approx(value, abs=1e-9 if unit == "Pa" else 0.5)
    assert abs(found[1, 2]) < 100  # of its neighbours
    tared = FrontEnd(ARRAY, Input(unit=unit), levels, known)(levels)  # type: ignore[arg-type]
    assert np.abs(tared).max() == 0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("gain = [[1.0]]", "form: Field required"),
        ('form = "tfra-calibration-1"\ngain = [[1.0]]', "gain: 4 lists of 5 numbers are needed"),
        ('form = "tfra-calibration-1"\ngain = [[-1.0]]', "gain.0.0: Input should be greater than or equal to 0"),
        ('form = "tfra-calibration-1"\ndead = [[4, 0]]', "dead: row 4, column 0 is no taxel"),
        (f'form = "tfra-calibration-1"\ndead = {[[n // 5, n % 5] for n in range(20)]}', "dead: at least one taxel"),
        ('form = "tfra-calibration-1"\ngains = 1', "gains: Extra inputs"),
    ],
)
def test_wrong_calibrations(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "cal.toml").write_text(text)
    with pytest.raises(InputError, match=re.escape(f"cal.toml: {reason}")):
        read_calibration(tmp_path / "cal.toml", SENSOR)


def test_config_names_a_calibration(tmp_path: Path) -> None:
    """Beside it; and recordings are read by it."""
    (tmp_path / "cal.toml").write_text(TABLES)
    sensor = "[sensor]\nrows = 4\ncolumns = 5\npitch_x_mm = 3\npitch_y_mm = 3\nthickness_mm = 2.5\n"
    (tmp_path / "mine.toml").write_text(f'{sensor}[input]\ncalibration = "cal.toml"\n')
    project = load(tmp_path / "mine.toml")
    np.save(tmp_path / "f.npy", np.full((1, 4, 5), 60.0))
    frames = read_recording(tmp_path / "f.npy", SENSOR, ADC, project.input).frames
    assert frames[0, 0, :2] == pytest.approx([50, 53.9])


def test_keys_that_do_not_fit_are_named() -> None:
    for reason, wrong in {
        "dead: row 4, column 0 is no taxel of 4 x 5, from 0": Input(dead=((4, 0),)),
        "rest_code: unipolar codes of 12 bits are from 0 to 4095, got 5000": Input(
            "codes", coding="unipolar", rest_code=5000.0
        ),
        "dead: at least one taxel has to be alive": Input(dead=tuple(np.ndindex(4, 5))),
        "pa_per_code: with the gains, up to 399.997 is supported, got 500": Input(unit="codes", pa_per_code=500.0),
    }.items():
        with pytest.raises(ValueError, match=reason):
            FrontEnd(ARRAY, wrong)
    with pytest.raises(ValueError, match="unit: only codes"):
        _ = FrontEnd(ARRAY, PLAIN).tables
    with pytest.raises(ValueError, match="at rest once: as a file, as first frames or as a code"):
        overridden(PLAIN, {"unit": "codes", "rest_code": 600.0, "tare_frames": 5})
    assert overridden(Input("codes", tare_frames=5), {"rest_code": 0.0}).tare_frames == 0
    assert overridden(Input("codes", rest_code=600.0), {"tare_frames": 0}).rest_code is None


def told(levels: Floats, rest: Floats | None = None, **given: Any) -> list[str]:
    how = Input(**given)
    return list(doubts(levels, rest, ADC, how, FrontEnd(ARRAY, how).alive))


def test_numbers_are_looked_at_before_the_tare() -> None:
    """Dead taxels, a press in the tare, noise in it, saturation; and nothing of what is right."""
    rng = np.random.default_rng(3)
    levels = 600.0 + rng.integers(-6, 7, (50, 4, 5))
    levels[20:, 1, 1] += 900
    codes = {"unit": "codes", "coding": "unipolar"}
    assert told(levels, levels[:16], **codes) == []
    dead = levels.copy()
    dead[:, 2, 3] = 17.0
    (line,) = told(dead, dead[:16], **codes)
    assert line == (
        "1 taxel reads the same in all 50 frames, (row, column) (2, 3) 17: is it dead? "
        "Neighbours can stand in (--dead 2,3)"
    )
    assert told(dead, dead[:16], **codes, dead=((2, 3),)) == []
    (line,) = told(levels, levels[10:26], **codes)
    assert re_found("within the tare, others are .* apart: did something press in its 16 frames", line)
    noisy = 600.0 + rng.integers(-200, 200, (50, 4, 5))
    (line,) = told(noisy, noisy[:16], **codes)
    assert re_found("apart in the tare, more than a contact has to be .16", line)
    high = levels.copy()
    high[25:, 0, 0] = 4095
    (line,) = told(high, high[:16], **codes)
    assert line.startswith("25 of 50 frames and 1 of 20 taxels read 0 or 4095")


def re_found(pattern: str, text: str) -> bool:
    return re.search(pattern, text) is not None


@pytest.mark.parametrize("share", [0.0005, 0.003])
def test_the_noise_that_a_tare_tells(tmp_path: Path, share: float) -> None:
    """TFRA's friction is doubted where it is over 0.1 % of the peaks."""
    rng, sensor = np.random.default_rng(5), SensorArray(6, 7, 3e-3, 3e-3, 2.5e-3)
    stress = frames(sensor, random_contacts(sensor, 20, rng))
    stress *= (1e5 / np.abs(stress).max(axis=(1, 2)))[:, None, None]
    whole = np.concatenate([np.zeros((30, 6, 7)), stress])
    np.save(tmp_path / "f.npy", whole + share * 1e5 * rng.normal(size=whole.shape))
    found = read_recording(tmp_path / "f.npy", sensor, ADC, Input(tare_frames=30))
    assert found.noise == pytest.approx(share * 1e5, rel=0.1)
    design, status = TfraDesign(sensor, adc=ADC), Tfra(sensor)(found.frames).status
    lines = warnings(design, found.frames, status, found.given, found.doubts, found.noise)
    noisy = [line for line in lines if line.startswith("the noise of a taxel is 0.3 % of the peaks")]
    assert len(noisy) == (share > 1e-3)
