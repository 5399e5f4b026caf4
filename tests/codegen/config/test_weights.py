"""WEIGHTS.npz comes back as it was written, and nothing else is taken for it."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.model.learned.random_weights import random_weights
from tfra.codegen.config import weights as weightsfile
from tfra.codegen.config.weights import Trained, read_weights, sensor_sha256, write_weights
from tfra.model.learned.network import NAMES, Weights
from tfra.model.sensor import SensorArray
from tfra.runtime.errors import InputError
from tfra.runtime.outputs import write_npz

SENSOR = SensorArray(4, 5, 4.1e-3, 2e-3, 3e-3)


def trained(taxels: int = SENSOR.taxels) -> Trained:
    drawn = random_weights(np.random.default_rng(0), taxels, 3, 2)
    rounded = Weights(*(getattr(drawn, name).astype(np.float32) for name in NAMES))
    curve = np.array([[100, 0.5, 0.6], [200, 0.3, 0.35]])
    return Trained(SENSOR, rounded, 0.25, {"mu": [0, 1.05], "seed": 7}, {"mu_median": 0.02}, curve)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_weights(tmp_path / "w.npz", trained())
    return tmp_path / "w.npz"


def refusal(path: Path, sensor: SensorArray = SENSOR) -> str:
    with pytest.raises(InputError) as caught:
        read_weights(path, sensor)
    told = str(caught.value)
    assert "\n" not in told
    assert told.startswith(f"{path}: ")
    return told.removeprefix(f"{path}: ")


def test_there_and_back(path: Path) -> None:
    found, expected = read_weights(path, SENSOR), trained()
    for name in NAMES:
        assert np.array_equal(getattr(found.weights, name), getattr(expected.weights, name)), name
    assert np.array_equal(found.curve, expected.curve)
    assert (found.sensor, found.threshold) == (SENSOR, 0.25)
    assert (found.prior, found.held_out) == (expected.prior, expected.held_out)


def test_equal_weights_give_equal_bytes(path: Path, tmp_path: Path) -> None:
    write_weights(tmp_path / "again.npz", trained())
    assert (tmp_path / "again.npz").read_bytes() == path.read_bytes()
    write_weights(path, replace(trained(), threshold=0.3))  # this command's own file may be replaced
    assert read_weights(path, SENSOR).threshold == 0.3


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"rows": 5, "columns": 4}, "sensor.rows: is trained for 4, CONFIG has 5: run tfra train again"),
        ({"columns": 6}, "sensor.columns: is trained for 5, CONFIG has 6"),
        ({"pitch_x": 4e-3}, "sensor.pitch_x_mm: is trained for 4.1, CONFIG has 4"),
        ({"thickness": 3.1e-3}, "sensor.thickness_mm: is trained for 3, CONFIG has 3.1"),
    ],
)
def test_another_sensor(path: Path, changed: dict[str, Any], reason: str) -> None:
    other = replace(SENSOR, **changed)
    assert refusal(path, other).startswith(reason)
    assert sensor_sha256(other) != sensor_sha256(SENSOR)


def test_damage(path: Path) -> None:
    """A bit anywhere before the seal, and every end."""
    whole = path.read_bytes()
    for place in np.linspace(0, whole.rindex(b"tfra ") - 1, 60).astype(int):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert re.search("has changed since tfra wrote it: run tfra train again|readable", refusal(path))
        path.write_bytes(whole[:place])
        assert re.search("readable|empty", refusal(path))


def test_files_of_others(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    assert refusal(path) == "cannot be read: No such file or directory"
    np.savez(path, a=np.zeros(3))
    assert refusal(path) == "is no file of tfra train: tfra did not write it: run tfra train again"
    path.unlink()
    write_npz(path, {"a": np.zeros(3)}, "estimate")
    assert refusal(path).startswith("is no file of tfra train: tfra estimate wrote it, not tfra train")


def forged(path: Path, change: Callable[[dict[str, Any], dict[str, Any]], object]) -> str:
    """Why the file is refused whose arrays and description ``change`` has changed, sealed again."""
    with np.load(path) as archive:
        arrays = dict(archive)
    about = json.loads(str(arrays["about"]))
    change(arrays, about)
    if "about" in arrays and arrays["about"].dtype.kind == "U" and arrays["about"] != "no JSON":
        arrays["about"] = np.array(json.dumps(about))
    write_npz(path, arrays, weightsfile.COMMAND)
    return refusal(path)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda a, d: a.pop("read2"), "read2: the key is missing: run tfra train again"),
        (lambda a, d: a.pop("about"), "about: the key is missing: run tfra train again"),
        (lambda a, d: a.update(about=np.array("no JSON")), "about: is no JSON: run tfra train again"),
        (lambda a, d: a.update(about=np.zeros(3)), "about: a text is needed, got float64"),
        (lambda a, d: d.update(format=3), "about.format: version 2 is needed, got 3: run tfra train again"),
        (lambda a, d: d.pop("format"), "about.format: version 2 is needed, got None: run tfra train again"),
        (lambda a, d: d.pop("threshold"), "about.threshold: is missing"),
        (lambda a, d: d.update(threshold=0), "about.threshold: "),
        (lambda a, d: d.update(threshold=float("nan")), "about.threshold: a finite number is needed, got nan"),
        (lambda a, d: d.update(colour=1), "about.colour: unknown key"),
        (lambda a, d: d["sensor"].update(rows=10**400), "sensor.rows: is trained for 1000"),
        (lambda a, d: d.update(sensor_sha256="0"), "about.sensor_sha256: is not that of the sensor"),
        (lambda a, d: a["first"].__setitem__((0, 0), np.nan), "first: a number is not finite"),
        (lambda a, d: a.update(second=a["second"][:3]), "second: shape (4, 2, 3) is needed, got (3, 2, 3)"),
        (lambda a, d: a.update(first=np.array(["x"])), "first: real numbers are needed"),
        (lambda a, d: a.update(curve=np.zeros(3)), "curve: finite numbers of shape (k, 3) are needed, got shape (3,)"),
        (
            lambda a, d: a.update(first=np.zeros((3, 6)), direct=np.zeros((4, 6))),
            "first: 20 taxels are needed, got 6",
        ),
    ],
)
def test_a_sealed_file_with_wrong_content(path: Path, change: Any, reason: str) -> None:
    assert forged(path, change).startswith(reason)


def test_what_must_not_be_written(tmp_path: Path) -> None:
    for wrong in (replace(trained(), threshold=0.0), replace(trained(), held_out={"mu": float("nan")})):
        with pytest.raises(ValueError, match=r"threshold|held_out"):
            write_weights(tmp_path / "w.npz", wrong)
    assert not (tmp_path / "w.npz").exists()
