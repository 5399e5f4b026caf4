"""Every wrong recording is told, and a good one is not."""

import itertools
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import lru_cache

import numpy as np
import pytest

from tfra.model.arrays import Floats
from tfra.model.choices import Adc, Architecture
from tfra.model.converter import quantise
from tfra.model.cover.scenes import SENSORS, contact_codes
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Status, Tfra
from tfra.recordings.diagnosis import over_full_scale, warnings
from tfra.recordings.input import PLAIN, Input, arranged

SQUARE, OBLONG = SENSORS["10×10, 4×2 mm, h 3 mm"], SENSORS["5×7, 3×3 mm, h 2 mm"]
REST, TOP = 12.0, 8191


def design(sensor: SensorArray, adc: Adc | None = None) -> Design:
    return TfraDesign(sensor, adc=adc or Adc(), architecture=Architecture(4))


@lru_cache
def contacts(sensor: SensorArray, count: int = 40, seed: int = 1) -> Floats:
    """Random contacts in Pa as a converter sees them, peaks at 10 to 95 % of full scale."""
    one = design(sensor)
    return contact_codes(one, count, seed) * one.adc.lsb


def told(frames: Floats, sensor: SensorArray = SQUARE, given: Input = PLAIN, adc: Adc | None = None) -> list[str]:
    return warnings(design(sensor, adc), frames, Tfra(sensor)(frames).status, given)


def noise(shape: tuple[int, ...], size: float) -> Floats:
    return np.random.default_rng(2).normal(size=shape) * size


def rest(count: int, sensor: SensorArray = SQUARE) -> Floats:
    return noise((count, sensor.rows, sensor.columns), REST)


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
@pytest.mark.parametrize("count", [20, 100])
def test_contacts_are_not_doubted(sensor: SensorArray, count: int) -> None:
    """Nor in one recording of many."""
    for seed in range(4):
        frames = contacts(sensor, count, seed)
        assert told(frames, sensor) == []
        assert told(frames + noise(frames.shape, 2e-3 * np.abs(frames).max()), sensor) == []


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_single_frames_are_not_doubted(sensor: SensorArray) -> None:
    """But for those without traction, where no tangential force can be found indeed."""
    frames = contacts(sensor, 100, 7)
    tension = (frames > 0).any(axis=(1, 2))
    for frame, some in zip(frames, tension, strict=True):
        lines = told(frame[None], sensor)
        assert lines == [] if some else lines[0].startswith("no tension in 100 % of the frames with a contact")


def test_contacts_between_pauses_are_not_doubted() -> None:
    frames = np.concatenate([rest(60), contacts(SQUARE), rest(60)])
    found = Tfra(SQUARE)(frames)
    quiet = replace(found, status=np.where(np.arange(160) % 100 < 60, Status.NO_CONTACT, found.status))
    assert warnings(design(SQUARE), frames, found.status) == warnings(design(SQUARE), frames, quiet.status) == []


def test_the_bit_accurate_model_is_not_doubted_either() -> None:
    one, frames = design(OBLONG), contacts(OBLONG)
    assert warnings(one, frames, decode(one, FixedTfra(one)(quantise(one, frames)).words).status) == []


# What is wrong with it


def scaled(peak: float) -> Floats:
    """Contacts whose largest magnitude is ``peak``."""
    frames = contacts(SQUARE)
    return frames / np.abs(frames).max() * peak


CONTACTS = contacts(SQUARE)
CODES = CONTACTS / design(SQUARE).adc.lsb
KPA, RAW = Input(unit="kPa"), Input(unit="codes")
SIGN = "99 % of the stress is {0}: is compression {0} in this file? (--compression {0})".format
FULL_SCALE, ENDS = "* times full scale: *adc.full_scale_pa in Pa (not in kPa)?", "40 of 40 frames and *"
ONE = next(frame for frame in CONTACTS if frame.max() > 1e3)

CASES: dict[str, tuple[Floats, Input, list[str]]] = {
    "sign": (-CONTACTS, PLAIN, [SIGN("positive")]),
    "sign that somebody has flipped": (-CONTACTS, Input(compression="positive"), [SIGN("negative")]),
    "kPa": (
        scaled(144.0),
        PLAIN,
        ["* is 144 Pa, 0.072 % of full scale, 200000 Pa: is the unit kPa (* 72 %)*"],
    ),
    "MPa": (scaled(0.144), PLAIN, ["the largest magnitude is 0.144 Pa, * is the unit MPa (times 1e+06 *"]),
    "bar": (scaled(1.0), PLAIN, ["the largest magnitude is 1 Pa, * is the unit bar (times *"]),
    "no unit": (scaled(1e-4), PLAIN, ["* are the unit, Pa, and adc.full_scale_pa correct, or was nothing pressed?"]),
    "MPa as kPa": (scaled(144.0), KPA, ["* is the unit MPa (times 1000 it would be 72 %), or was nothing pressed?"]),
    "no unit as kPa": (scaled(1.44), KPA, ["* are the unit, kPa, and adc.full_scale_pa correct, or was *"]),
    "low codes": (scaled(144.0), RAW, ["* are the unit, codes, and adc.full_scale_pa correct, or was *"]),
    "Pa as kPa": (scaled(144e6), KPA, [f"{FULL_SCALE} (--unit Pa)", ENDS]),
    "full scale in kPa": (scaled(144e6), RAW, [FULL_SCALE, ENDS]),
    "codes": (CODES, PLAIN, ["all values are whole numbers up to *14-bit * (1 code = 24.4141 Pa)? (--unit codes)"]),
    "halves": (CODES + 0.5, PLAIN, []),
    "offset binary codes": (
        CODES + 8192,
        PLAIN,
        ["taxels read about 8* a common offset: *, or are these codes with *?", "all values * --coding offset)"],
    ),
    "an offset of codes": (
        CONTACTS + 5e3,
        RAW,
        ["* offset: was the sensor tared (--tare-frames N, --tare FILE)?"],
    ),
    "compression only": (np.minimum(CONTACTS, 0), PLAIN, ["no tension in 100 % of the frames with a contact, so *"]),
    "compression only with the wrong sign": (np.maximum(-CONTACTS, 0), PLAIN, ["100 % * is positive: *"]),
    "stuck": (np.repeat(ONE[None], 7, axis=0), PLAIN, ["all 7 frames are the same: is the recording stuck?"]),
}


@pytest.mark.parametrize(("frames", "given", "patterns"), CASES.values(), ids=CASES)
def test_what_is_wrong_is_told(frames: Floats, given: Input, patterns: list[str]) -> None:
    lines = told(frames, given=given)
    assert len(lines) == len(patterns)
    assert all(map(fnmatchcase, lines, patterns)), lines


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_sign_of_few_frames(sensor: SensorArray) -> None:
    (line,) = told(-contacts(sensor, 20, 2), sensor)
    assert line.endswith("is compression positive in this file? (--compression positive)")


def test_codes_on_a_grid_of_whole_pascals_are_pascals() -> None:
    adc = Adc(14, 2.0**17)
    codes = contact_codes(design(SQUARE, adc), 40, 3)
    assert told(codes * adc.lsb, adc=adc) == []


@pytest.mark.parametrize("flips", [(False, False), (False, True), (True, False), (True, True)])
@pytest.mark.parametrize("name", ["5×7, 3×3 mm, h 2 mm", "4×6, 5×3 mm, h 2 mm"])
def test_an_order_that_is_not_that_of_the_file(name: str, flips: tuple[bool, bool]) -> None:
    """The right reading is not doubted."""
    sensor, orders = SENSORS[name], ("rows", "columns")
    for written, order in itertools.product(orders, orders):
        frames = contacts(sensor, 40, 9)
        lines = (frames if written == "rows" else frames.transpose(0, 2, 1)).reshape(40, -1)
        given = Input(order=order, flip_x=flips[0], flip_y=flips[1])  # type: ignore[arg-type]  # a str of the table
        doubts = [line for line in told(arranged(lines, given, sensor), sensor, given) if "neighbours differ" in line]
        way = written.removesuffix("s")
        asked = "are rows and columns swapped in the file "
        ending = f"{way} by {way}: {asked}(--order {written}), or in CONFIG's [sensor]?"
        assert [line.endswith(ending) for line in doubts] == [True] * (written != order)


@pytest.mark.parametrize("share", [-0.3, -0.1, 0.03, 0.1, 0.3])
@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_offset(sensor: SensorArray, share: float) -> None:
    frames = contacts(sensor, 40, 5)
    off = share * np.abs(frames).max()
    for spread in (0.0, 0.1):
        per_taxel = off * (1 + spread * np.random.default_rng(4).uniform(-1, 1, frames.shape[1:]))
        assert any("a common offset: was the sensor tared" in line for line in told(frames + per_taxel, sensor)), spread


def test_offset_of_a_sensor_at_rest() -> None:
    frames = np.concatenate([contacts(SQUARE), rest(40) + 400.0])
    assert any("a common offset" in line for line in told(frames))


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_an_offset_of_every_taxel(sensor: SensorArray) -> None:
    """As tall as it may be, if it is the same while nothing presses; noise of the same size is none."""
    pressed = contacts(sensor, 40, 5)
    frames = np.concatenate([np.zeros((10, *pressed.shape[1:])), pressed])
    assert told(frames, sensor) == []
    for share in (0.01, 0.03, 0.1):
        size = share * np.abs(pressed).max()
        offset = size * np.random.default_rng(6).uniform(-1, 1, pressed.shape[1:])
        lines = told(frames + offset + noise(frames.shape, 0.05 * size), sensor)
        assert any("the same in every frame: was the sensor tared" in line for line in lines), share
        assert not any("was the sensor tared" in line for line in told(frames + noise(frames.shape, size), sensor))


def test_sensor_at_rest() -> None:
    frames = rest(100) * 400
    quiet = replace(Tfra(SQUARE)(frames), status=np.full(100, int(Status.NO_CONTACT)))
    rested = warnings(design(SQUARE), frames, quiet.status)
    assert rested == ["100 of 100 frames have no contact: was the sensor at rest?"]
    two = warnings(design(SQUARE), frames / 400, quiet.status)
    assert len(two) == 2
    assert "% of full scale, 200000 Pa: is the unit kPa (times 1000 it would be " in two[1]


def test_saturated() -> None:
    frames = contacts(SQUARE) * 1.5
    clipped = np.clip(frames, -2e5, 2e5)
    assert told(np.clip(frames, -1.99e5, 1.99e5)) == []
    hit = np.abs(frames) >= 2e5
    line = (
        f"{hit.any(axis=(1, 2)).sum()} of 40 frames and {hit.any(axis=0).sum()} of 100 taxels reach an end of the "
        "converter's range, ±200000 Pa: was it saturated (the forces would be too small)?"
    )
    assert told(clipped) == [line]
    far = told(frames * 1e3)
    assert far[0].endswith("times full scale: is the file in Pa, and adc.full_scale_pa in Pa (not in kPa)?")
    assert far[1].startswith("40 of 40 frames and ")
    rare = np.concatenate([contacts(SQUARE, 200, 3), clipped[hit.any(axis=(1, 2))][:1]])
    assert told(rare) == []  # one of 201 is below 1 %


def test_stuck_taxels() -> None:
    frames = contacts(SQUARE).copy()
    frames[:, 3, 4] = -5e4
    assert told(frames) == [
        "1 taxel reads the same in all 40 frames, (row, column) (3, 4) -50000: is it dead? "
        "Neighbours can stand in (--dead 3,4)"
    ]
    frames[:, 4, 2:8] = -6e4
    assert told(frames)[0] == (
        "7 taxels read the same in all 40 frames, (row, column) (3, 4) -50000, (4, 2) -60000, (4, 3) -60000, "
        "(4, 4) -60000, (4, 5) -60000 ...: are they dead? Neighbours can stand in (--dead 3,4)"
    )


def test_most_frames_flagged() -> None:
    frames = contacts(SQUARE)
    found = Tfra(SQUARE)(frames)
    status = found.status.copy()
    status[::2] = Status.NO_CONTACT
    status[1::4] = status[3::8] = Status.DEPENDENT_OUT_OF_RANGE
    odd = replace(found, status=status)
    assert warnings(design(SQUARE), frames, odd.status) == [
        "75 % of the frames with a contact: dependent out of range (the dependent friction coefficient exceeds 1)"
    ]


# Frames that fixed and rtl refuse


def test_over_full_scale() -> None:
    one, frames = design(SQUARE), contacts(SQUARE)
    peak = np.abs(frames).max()
    assert over_full_scale(one, frames / peak * 3e5) == ""
    assert over_full_scale(one, frames / peak * 1.44e8) == (
        "; the largest magnitude is 720 times full scale: is the file in Pa, and adc.full_scale_pa in Pa (not in kPa)?"
    )
    soft = design(SQUARE, Adc(14, 5e4))
    assert over_full_scale(soft, np.rint(frames / peak * 8000)) == (
        "; all values are whole numbers up to 8000: are these codes of the 14-bit converter instead of Pa "
        "(1 code = 6.10352 Pa)? (--unit codes)"
    )


def test_codes_of_another_unit_or_an_offset_of_codes() -> None:
    """Whole numbers in kPa, too; unsigned codes about a rest that is not half of the range."""
    one, frames = design(SQUARE), contacts(SQUARE)
    codes = np.rint(frames / np.abs(frames).max() * 900)
    (line,) = [line for line in told(1000 * codes, given=Input(unit="kPa")) if "whole numbers" in line]
    assert "whole numbers up to 900: are these codes of the 14-bit converter instead of kPa" in line
    shifted = (codes - 6000) * one.adc.lsb
    assert any("a common offset" in line for line in told(shifted, given=Input(unit="codes", coding="offset")))
