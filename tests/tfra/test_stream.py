"""Streams of the library: frames as they come give what a recording of them gives."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tfra

EXAMPLES = Path(__file__).parents[2] / "examples"
KEYS = {"unit": "codes", "coding": "offset", "order": "columns", "average": 2, "tare_frames": 3, "drift_frames": 40}


@pytest.fixture(scope="module")
def sensor() -> tfra.Sensor:
    return tfra.load(EXAMPLES / "skin_8x12.toml")


def recorded(sensor: Any) -> np.ndarray:
    """Codes of seven frames at rest, then of contacts with a pause, along columns."""
    rng = np.random.default_rng(4)
    codes = np.rint(sensor.simulate()[0] / sensor.adc.lsb)
    frames = np.concatenate([np.zeros((7, *sensor.shape)), np.repeat(codes[:4], 2, axis=0)])
    half = 1 << (sensor.adc.bits - 1)
    return np.clip(half + 30 + frames + rng.integers(-1, 2, frames.shape), 0, 2 * half - 1).transpose(0, 2, 1)


@pytest.mark.parametrize("engine", ["float", "c"])
@pytest.mark.parametrize("parts", [1, 4, 15])
def test_it_finds_what_is_in_a_recording(sensor: tfra.Sensor, tmp_path: Path, engine: Any, parts: int) -> None:
    frames = recorded(sensor)
    np.save(tmp_path / "f.npy", frames)
    expected = sensor.estimate(sensor.read(tmp_path / "f.npy", **KEYS), engine)  # type: ignore[arg-type]
    stream = sensor.stream(engine, **KEYS)
    pieces = np.array_split(frames, parts)
    found = [result for piece in pieces if (result := stream(piece[0] if len(piece) == 1 else piece)) is not None]
    assert isinstance(found[0], tfra.Result)
    for name in ("stress", "resultant", "mu", "phi_deg", "status", "forces"):
        joined = np.concatenate([getattr(result, name) for result in found])
        np.testing.assert_allclose(joined, getattr(expected, name)[3:], rtol=1e-9, atol=1e-9)


def test_a_new_tare(sensor: tfra.Sensor) -> None:
    frames, _ = sensor.simulate()
    stream = sensor.stream(unit="kPa", tare_frames=2)
    assert repr(stream) == "<tfra stream of skin_8x12, Tare: keep the array at rest, 0 of 2 frames have come.>"
    offset = 7.0
    first, second = stream(np.stack([0 * frames[0], 0 * frames[0], frames[0] / 1000])), None
    stream.tare()
    for frame in (0 * frames[0], 0 * frames[0]):
        assert second is None
        second = stream(frame + offset)
    second = stream(frames[0] / 1000 + offset)
    assert first is not None
    assert second is not None
    np.testing.assert_allclose(first.mu, second.mu, rtol=1e-9)
    assert len(first) == len(second) == 1


def test_contacts_of_a_skin() -> None:
    skin = tfra.load_skin(EXAMPLES / "fingers_32x32.toml")
    frames, _ = skin.simulate()
    stream = skin.stream("c", unit="kPa")
    assert stream.told == ""
    found = stream(frames[2] / 1000)
    assert isinstance(found, tfra.Contacts)
    assert found.found.tolist() == [4]


@pytest.mark.parametrize(
    ("frames", "given", "line"),
    [
        (np.zeros((12, 8)), {}, r"Sensor\.stream: frames: shape \(8, 12\) or \(n, 8, 12\) is needed, got \(12, 8\)"),
        (np.zeros(96), {}, r"got \(96,\)"),
        ([["a"] * 12] * 8, {}, "Sensor.stream: frames: real numbers in one array are needed"),
        (np.full((8, 12), np.nan), {"unit": "kPa"}, "Sensor.stream: frames: frame 0, row 0, column 0 is not finite"),
        (np.full((8, 12), 1e13), {}, "column 0 is 1e[+]13 Pa, the limit is 1e[+]12 Pa"),
        (np.full((8, 12), 9000), {"unit": "codes"}, "signed codes of 12 bits are from -2048 to 2047"),
        (np.full((8, 12), -9e9), {"engine": "c"}, "full scale"),
        ([], {"unit": "psi"}, "Sensor.stream: unit: 'Pa', 'kPa' or 'codes' is needed, got 'psi'"),
        ([], {"average": 3}, "Sensor.stream: average: one of 1, 2, 4, 8, 16, 32, 64 is needed, got 3"),
        ([], {"speed": 3}, "Sensor.stream: speed: "),
        ([], {"engine": "fast"}, "Sensor.stream: engine: one of float, fixed, c, rtl, two-variable is needed"),
        ([], {"tare": "none.csv"}, "none.csv: cannot be read"),
    ],
)
def test_what_is_wrong_is_told(sensor: tfra.Sensor, frames: Any, given: dict[str, Any], line: str) -> None:
    with pytest.raises(tfra.InputError, match=line):
        sensor.stream(**given)(frames)
