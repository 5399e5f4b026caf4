"""``import tfra``: the same numbers as the models and the commands, and mistakes told in one line."""

import doctest
import importlib
import math
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from setuptools import find_packages

import tfra
from tests.cli.test_cli import CONFIG
from tfra.array import _as_arguments
from tfra.cli.main import main
from tfra.codegen.config import read as config
from tfra.model.converter import quantise
from tfra.model.cover.layer import frames as layer_frames
from tfra.model.fixed.words import decode
from tfra.model.metrics import errors
from tfra.model.tfra import Tfra
from tfra.recordings.results import KEYS
from tfra.runtime.errors import InputError

EXAMPLES = Path(__file__).parents[2] / "examples"
SKIN = EXAMPLES / "skin_8x12.toml"

@pytest.fixture(scope="module")
def sensor() -> tfra.Sensor:
    return tfra.load(SKIN)


@pytest.fixture(scope="module")
def simulated(sensor: tfra.Sensor) -> tuple[Any, tfra.Truth]:
    return sensor.simulate()


def test_import_is_light() -> None:
    """Whatever takes long is imported when it is first asked for; nothing but the file itself is."""
    code = "import sys; before = set(sys.modules); import tfra; print(*sorted(set(sys.modules) - before))"
    found = subprocess.run([sys.executable, "-S", "-c", f"import site; site.main(); {code}"], capture_output=True)
    assert set(found.stdout.decode().split()) <= {"tfra", "__future__"}


def test_every_package_is_installed() -> None:
    """The folder ``tfra`` has a link to each room, setuptools finds the same packages, and ``tfra`` is typed."""
    root, package = EXAMPLES.parent, EXAMPLES.parent / "tfra"
    rooms = {file.parent.name for file in root.glob("*/__init__.py")} - {"bench", "tests", "tfra"}
    assert {link.name for link in package.iterdir() if link.is_symlink()} == rooms
    assert all((package / room).resolve() == root / room for room in rooms)
    folders = {file.parent for room in rooms for file in (root / room).rglob("__init__.py")}
    packages = {folder for folder in folders if folder.parent in folders or folder.parent == root}
    names = {".".join(("tfra", *folder.relative_to(root).parts)) for folder in packages}
    assert set(find_packages(str(root), include=["tfra", "tfra.*"])) == {"tfra", *names}
    assert (package / "py.typed").exists()


def test_every_name_is_there_and_documented() -> None:
    assert set(tfra.__all__) <= set(dir(tfra))
    for name in tfra.__all__:
        assert name == "__version__" or getattr(tfra, name).__doc__
    assert tfra.InputError is InputError
    with pytest.raises(AttributeError, match="has no attribute 'laod'"):
        getattr(importlib.import_module("tfra"), "laod")  # noqa: B009  # the lookup is what is tested
    for name, value in vars(tfra.Sensor).items():
        assert name.startswith("_") or name == "project" or value.__doc__, name


@pytest.mark.parametrize("name", ["tfra", "tfra.sensor", "tfra.skin", "tfra.result"])
def test_examples_of_docstrings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, simulated: tuple[Any, tfra.Truth]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(EXAMPLES)
    rest, frames = np.zeros((50, 96)), simulated[0][:10].reshape(10, -1) / -1000 + 0.25
    np.savetxt("log.csv", np.vstack([rest + 0.25, frames]), delimiter=",")
    found = doctest.testmod(importlib.import_module(name), extraglobs={"tfra": tfra})
    assert (found.failed, found.attempted > 2) == (0, True)


def test_a_sensor_says_what_its_file_says(sensor: tfra.Sensor) -> None:
    assert sensor.shape == (8, 12)
    assert (sensor.adc.bits, sensor.adc.full_scale, sensor.formats.name) == (12, 150e3, "standard")
    assert (len(sensor.contacts), sensor.input.unit) == (12, "Pa")
    for part in ("skin_8x12", "8×12", "3 × 2.5 mm", "under 2 mm", "12 bits", "150000 Pa", "12 contacts"):
        assert part in repr(sensor)
    with pytest.raises(AttributeError):
        sensor.project = None  # type: ignore[misc, assignment]  # what mypy forbids is tried


def test_simulated_frames_are_those_of_the_cover(sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth]) -> None:
    frames, truth = simulated
    project = config.load(SKIN)
    np.testing.assert_array_equal(
        frames, layer_frames(project.design.sensor, project.contacts, "point", project.layer.poisson)
    )
    assert truth.phi_deg.tolist() == [30.0 * n for n in range(12)]
    assert truth.mu.tolist() == [0.5] * 12
    np.testing.assert_allclose(truth.resultant[3], (0, 2, -4), atol=1e-12)
    mine = tfra.Contact(tfra.ContactShape.UNIFORM, 0.015, 0.01, 4e-3, 4e-3, -2.0, 0.3, math.radians(70))
    own, known = sensor.simulate([mine])
    assert own.shape == (1, 8, 12)
    assert known.phi_deg.tolist() == [70.0]
    assert own.sum() * sensor.array.taxel_area == pytest.approx(-2.0, rel=0.05)


def test_engines_are_the_models(sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth]) -> None:
    frames, _ = simulated
    design = sensor.project.design
    codes = quantise(design, frames)
    expected = {
        ("float", False): Tfra.of(design)(frames),
        ("float", True): Tfra.of(design)(codes * design.adc.lsb),
        ("fixed", False): decode(design, design.model(codes).words),
    }
    for (engine, converted), model in expected.items():
        found = sensor.estimate(frames, engine, codes=converted)  # type: ignore[arg-type]  # a str of the table
        for key in KEYS:
            np.testing.assert_array_equal(getattr(found, key), getattr(model, key))
        assert found.engine == engine
        assert found.stress is not None
        assert (len(found), found.notices) == (12, ())
    assert not np.array_equal(expected["float", False].mu, expected["float", True].mu)


def test_one_frame_is_a_batch_of_one(sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth]) -> None:
    frames, _ = simulated
    np.testing.assert_array_equal(sensor.estimate(frames[5]).forces, sensor.estimate(frames[5:6]).forces)
    np.testing.assert_array_equal(
        sensor.estimate(frames[5].tolist(), "fixed").mu, sensor.estimate(frames, "fixed").mu[5:6]
    )


def test_files_are_those_of_the_command(
    sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bytes of an archive and of tables; the recording with its times, in another unit and sign."""
    monkeypatch.chdir(tmp_path)
    frames, _ = simulated
    text = "\n".join(",".join([f"{n / 8}", *(f"{-x / 1000!r}" for x in row)]) for n, row in enumerate(rows(frames)))
    Path("log.csv").write_text(text)
    recording = sensor.read("log.csv", unit="kPa", compression="positive", skip_columns=1)
    assert recording.time is not None
    assert recording.time.tolist() == [n / 8 for n in range(12)]
    np.testing.assert_allclose(recording.frames, frames, rtol=1e-15)
    options = ["--unit", "kPa", "--compression", "positive", "--skip-columns", "1", "--engine", "fixed"]
    found = sensor.estimate(recording, engine="fixed")
    for form in ("npz", "csv", "parquet"):
        found.save(f"mine.{form}")
        assert main(["estimate", str(SKIN), "log.csv", *options, "--out", f"theirs.{form}"]) == 0
    assert Path("mine.npz").read_bytes() == Path("theirs.npz").read_bytes()
    for form in ("csv", "parquet"):
        for file in Path(f"theirs.{form}").iterdir():
            assert (Path(f"mine.{form}") / file.name).read_bytes() == file.read_bytes()
    found.save(Path("mine.npz"))  # its own may be replaced
    Path("mine.npz").write_bytes(b"a thesis")
    with pytest.raises(tfra.InputError, match=r"^mine.npz: is not replaced: tfra did not write it"):
        found.save("mine.npz")


def rows(frames: Any) -> Any:
    return frames.reshape(len(frames), -1).tolist()


def test_errors(sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth]) -> None:
    frames, truth = simulated
    found = sensor.estimate(frames)
    table = found.errors(truth)
    np.testing.assert_array_equal(table["mu_abs"], np.abs(found.mu - 0.5))
    expected = errors(truth, found)
    assert {key: table[key].tolist() for key in table} == {key: expected[key].tolist() for key in expected}
    line = next(line for line in repr(table).splitlines() if line.startswith("μ, absolute"))
    median, high = (float(x) for x in line.split()[-2:])
    assert median == pytest.approx(np.median(table["mu_abs"]), rel=5e-3)
    assert high == pytest.approx(np.percentile(table["mu_abs"], 95), rel=5e-3)
    assert f"<td>{median:.3g}</td>" in table._repr_html_()
    assert max(sensor.estimate(frames).errors(found)["force_n"]) == 0
    with pytest.raises(tfra.InputError, match=r"^Result.errors: truth: is of 12 frames, the result has 3$"):
        sensor.estimate(frames[:3]).errors(truth)


def test_a_page(
    sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    frames, truth = simulated
    fixed, exact = sensor.estimate(frames, "fixed"), sensor.estimate(frames)
    page = fixed.view("page.html", truth=truth, beside={"exact": exact})
    written = Path("page.html").read_text()
    assert written.startswith(page.html)  # the seal follows
    for label in ("result (fixed)", "exact (float)", "truth (reference)"):
        assert label in page.html
    assert page._repr_html_().startswith('<iframe src="page.html"')
    inline = exact.view()
    assert (inline.path, "srcdoc=" in inline._repr_html_()) == (None, True)
    with pytest.raises(tfra.InputError, match="beside: short: is of another sensor or number of frames"):
        fixed.view(beside={"short": sensor.estimate(frames[:3])})
    with pytest.raises(tfra.InputError, match=r"must end in \.html"):
        fixed.view("page.pdf")
    monkeypatch.setattr("tfra.runtime.errors.find_spec", lambda name: None)
    with pytest.raises(tfra.InputError, match=r"plotly is missing, please run: pip install 'tfra\[view\]'"):
        fixed.view()


# Mistakes


def put(place: tuple[int, ...], value: float) -> Any:
    frames = np.zeros((2, 8, 12))
    frames[place] = value
    return frames


@pytest.mark.parametrize(
    ("frames", "reason"),
    [
        (np.zeros((2, 12, 8)), "frames: shape (n, 8, 12) with n >= 1 is needed, got (2, 12, 8)"),
        (np.zeros((0, 8, 12)), "frames: shape (n, 8, 12) with n >= 1 is needed, got (0, 8, 12)"),
        (put((1, 2, 3), math.nan), "frames: frame 1, row 2, column 3 is not finite"),
        (put((0, 2, 3), -1e12), "frames: frame 0, row 2, column 3 is -1e+12 Pa, over the full scale of 150000 Pa"),
        ("log.csv", "frames: real numbers in one array are needed"),
        ([[1.0], [2.0, 3.0]], "frames: real numbers in one array are needed"),
        (np.zeros((8, 12), complex), "frames: real numbers in one array are needed"),
    ],
)
def test_frames_that_are_none(sensor: tfra.Sensor, frames: Any, reason: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(tfra.InputError) as told:
            sensor.estimate(frames, "fixed")
    assert str(told.value).startswith(f"Sensor.estimate: {reason}")
    assert "\n" not in str(told.value)


def test_arguments_that_are_none(sensor: tfra.Sensor, tmp_path: Path) -> None:
    frames = np.zeros((8, 12))
    np.save(tmp_path / "f.npy", frames)
    calls: dict[str, Any] = {
        "Sensor.estimate: engine: one of float, fixed, c, rtl, two-variable is needed, got 'flaot'": (
            lambda: sensor.estimate(frames, "flaot")  # type: ignore[arg-type]  # wrong on purpose
        ),
        "Sensor.estimate: codes: the fixed engine always sees": lambda: sensor.estimate(frames, "fixed", codes=True),
        "Sensor.read: unit: 'Pa', 'kPa' or 'codes' is needed, got 'psi'": (
            lambda: sensor.read(tmp_path / "f.npy", unit="psi")  # type: ignore[arg-type]  # wrong on purpose
        ),
        "Sensor.read: tare_frames: 0 or more is needed, got -1": lambda: sensor.read("f.npy", tare_frames=-1),
        "Sensor.read: coding: only codes have a coding": lambda: sensor.read("f.npy", coding="offset"),
        "Sensor.simulate: contacts: a list of tfra.Contact is needed": (
            lambda: sensor.simulate(sensor.contacts[0])  # type: ignore[arg-type]  # wrong on purpose
        ),
        "no.csv: cannot be read": lambda: sensor.read("no.csv"),
    }
    for message, call in calls.items():
        with pytest.raises(tfra.InputError) as told:
            call()
        assert str(told.value).startswith(message)
    short = r"f.npy: frames: the first 9 frames are the tare, the recording has 1 \(tare_frames\)$"
    with pytest.raises(tfra.InputError, match=short):
        sensor.read(tmp_path / "f.npy", tare_frames=9)


def test_no_contact_and_one_beside_the_cover(tmp_path: Path, sensor: tfra.Sensor) -> None:
    (tmp_path / "bare.toml").write_text(CONFIG.partition("[[contact]]")[0])
    with pytest.raises(tfra.InputError, match=r"bare.toml: contact: at least one \[\[contact\]\] is needed"):
        tfra.load(tmp_path / "bare.toml").simulate()
    beside = tfra.Contact(tfra.ContactShape.HERTZ, 1.0, 0.01, 4e-3, 4e-3, -2.0, 0.3, 0.0)
    with pytest.raises(tfra.InputError, match="leaves the block"):
        sensor.simulate([beside])


def test_the_wrong_sign_is_told(sensor: tfra.Sensor, simulated: tuple[Any, tfra.Truth]) -> None:
    with pytest.warns(tfra.Notice, match=r'compression positive in this file\? \(compression="positive"\)$'):
        found = sensor.estimate(-simulated[0])
    assert found.notices[0] in repr(found)
    with pytest.warns(tfra.Notice) as told:
        sensor.estimate(simulated[0] / 1000)
    assert any('(unit="kPa")' in str(notice.message) for notice in told)


@pytest.mark.parametrize(
    ("option", "argument"),
    [
        ("(--unit kPa)", '(unit="kPa")'),
        ("(--unit codes --coding offset)?", '(unit="codes", coding="offset")?'),
        ("(--tare-frames N, --tare FILE)", "(tare_frames=N, tare=FILE)"),
        ("(--skip-columns 1)", "(skip_columns=1)"),
        ("is the unit Pa or kPa? (--unit)", "is the unit Pa or kPa? (unit)"),
        ("a - b -- c", "a - b -- c"),
    ],
)
def test_options_are_arguments_here(option: str, argument: str) -> None:
    assert _as_arguments(option) == argument


def test_a_result_as_a_table(sensor: tfra.Sensor) -> None:
    result = sensor.estimate(sensor.simulate()[0])
    table = result.to_dataframe()
    assert table.columns == list(result.table)
    assert table["mu"].to_list() == result.mu.tolist()
    assert table["fx_n"].to_list() == result.resultant[:, 0].tolist()
    assert result._repr_html_().count("<tr>") == 13
