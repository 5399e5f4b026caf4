"""Results and references are read as they were written, and anything else is told in a line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.view.made import CONFIG, KEYS, write
from tfra.recordings.results import KEYS as WRITTEN
from tfra.runtime.errors import InputError
from tfra.view.resultfile import CONTEXT, VALUES, read_all

Arrays = dict[str, Any]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Arrays]]:
    folder = tmp_path_factory.mktemp("results")
    return folder, write(folder)


def test_all_keys_that_estimate_writes_are_read() -> None:
    assert {*VALUES, "forces"} == set(KEYS) <= set(WRITTEN)


def test_what_was_written_is_read(made: tuple[Path, dict[str, Arrays]]) -> None:
    folder, arrays = made
    paths = [folder / f"{name}.npz" for name in ("frames", "float", "fixed")]
    results, known = read_all(paths)
    assert [(one.name, one.engine) for one in results] == [("float.npz", "float"), ("fixed.npz", "fixed")]
    for result, name in zip(results, ("float", "fixed"), strict=True):
        for key in KEYS:
            np.testing.assert_array_equal(getattr(result.found, key), arrays[name][key])
        np.testing.assert_array_equal(result.stress, arrays[name]["stress"])
        assert result.design.search.tolerance == 3
    assert results[1].time is None
    np.testing.assert_array_equal(results[0].time, arrays["float"]["time"])
    for key in ("mu_ref", "phi_ref_deg", "resultant_ref"):
        np.testing.assert_array_equal(known[0].values[key], arrays["frames"][key])


def lacking(key: str) -> Callable[[Arrays], Arrays]:
    return lambda held: {name: array for name, array in held.items() if name != key}


def having(**changed: Any) -> Callable[[Arrays], Arrays]:
    return lambda held: held | changed


OLD = "the key is missing, an earlier version made this file: run tfra estimate again"

WRONG = {
    **{key: (lacking(key), f"{key}: {OLD}") for key in CONTEXT},
    "no result": (lambda held: {"a": held["mu"]}, "forces: is no result of tfra estimate: the key is missing, the fil"),
    "frames": (lambda held: {"frames": held["stress"]}, "frames without reference values: one of resultant_ref, mu_r"),
    "key": (lacking("mu_x"), "mu_x: the key is missing"),
    "shape": (having(mu=np.zeros(3)), "mu: shape (24,) is needed, got (3,)"),
    "rows": (having(stress=np.zeros((24, 5, 6))), "stress: shape (n, 4, 6) is needed, got (24, 5, 6)"),
    "no frames": (having(stress=np.zeros((0, 4, 6))), "stress: at least one frame is needed, got none"),
    "nan": (having(phi_deg=np.full(24, np.nan)), "phi_deg: frame 0 has a value that is not finite"),
    "nan residual": (having(residual=np.full(24, np.nan)), "residual: frame 0 has a value that is not finite"),
    "no forces": (having(forces=np.full((24, 3, 4, 6), np.nan)), "forces: frame 0 has a value that is not finite"),
    "no threshold": (having(uncertainty=np.ones(24)), f"threshold: {OLD}"),
    "thresholds": (having(uncertainty=np.ones(24), threshold=np.ones(24)), "threshold: shape () is needed, got (24,)"),
    "nan threshold": (having(uncertainty=np.ones(24), threshold=np.nan), "threshold: a positive number is needed"),
    "zero threshold": (having(uncertainty=np.ones(24), threshold=0), "threshold: a positive number is needed, got 0"),
    "status": (having(status=np.full(24, 256)), "status: frame 0: is no status"),
    "half a status": (having(status=np.full(24, 0.5)), "status: whole numbers are needed"),
    "large index": (having(sweep_index=np.full(24, 1e300)), "sweep_index: whole numbers are needed"),
    "index": (having(sweep_index=np.full(24, 101)), "sweep_index: frame 0: is no candidate of 101"),
    "text": (having(engine=np.zeros(3)), "engine: a text is needed, got float64"),
    "bad config": (having(config=np.array("[sensor]\nrows = 1")), "config: sensor.columns: "),
    "no config": (having(config=np.array("rows =")), "config: "),
}


@pytest.mark.parametrize(("change", "line"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_told_in_a_line(
    made: tuple[Path, dict[str, Arrays]], tmp_path: Path, change: Callable[[Arrays], Arrays], line: str
) -> None:
    file = tmp_path / "r.npz"
    np.savez(file, **change(made[1]["float"]))
    with pytest.raises(InputError) as caught:
        read_all([file])
    assert str(caught.value).startswith(f"{file}: {line}")
    assert "\n" not in str(caught.value)


def test_all_files_are_of_one_sensor_and_as_many_frames(made: tuple[Path, dict[str, Arrays]], tmp_path: Path) -> None:
    folder, arrays = made
    other = CONFIG.replace("pitch_y_mm = 3", "pitch_y_mm = 3.5")
    np.savez(tmp_path / "other.npz", **arrays["float"] | {"config": np.array(other)})
    few = {key: array[:5] if np.ndim(array) else array for key, array in arrays["float"].items()}
    np.savez(tmp_path / "few.npz", **few)
    np.savez(tmp_path / "ref.npz", **{key: array[:5] for key, array in arrays["frames"].items()})
    needed = "4×6 taxels, 4 × {} mm apart, under 3 mm"
    lines = {
        "other.npz": f"config: is of another sensor ({needed.format(3.5)}) than float.npz ({needed.format(3)})",
        "few.npz": "has 5 frames, float.npz has 24",
        "ref.npz": "has 5 frames, float.npz has 24",
    }
    for name, line in lines.items():
        with pytest.raises(InputError) as caught:
            read_all([folder / "float.npz", tmp_path / name])
        assert str(caught.value) == f"{tmp_path / name}: {line}"
    with pytest.raises(InputError, match=r"frames\.npz: forces: at least one result of tfra estimate is needed"):
        read_all([folder / "frames.npz"])


def test_a_damaged_text_is_told(made: tuple[Path, dict[str, Arrays]], tmp_path: Path) -> None:
    file = tmp_path / "r.npz"
    data = (made[0] / "float.npz").read_bytes()
    place = data.index("float".encode("utf-32-le"))
    file.write_bytes(data[:place] + b"x" + data[place + 1 :])
    with pytest.raises(InputError, match=r"r\.npz: engine: is damaged: Bad CRC"):
        read_all([file])
