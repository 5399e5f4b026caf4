"""[input] of CONFIG and the options that override it, from a recording to RESULT, in every form of it."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import polars as pl
import pytest
from mcap.reader import make_reader

from tests.cli.test_cli import CONFIG, refusal
from tfra.cli.inputs import OPTIONS
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.model.converter import quantise
from tfra.recordings.frames import Recording
from tfra.recordings.input import PLAIN, Input, overridden
from tfra.recordings.results import KEYS, Estimate
from tfra.runtime.outputs import write_npz

PLAIN_CONFIG = CONFIG.partition("[[contact]]")[0]

INPUT = """
[input]
unit = "codes"
compression = "positive"
coding = "offset"
order = "columns"
flip_y = true
skip_columns = 1
tare = "rest.csv"
"""

AS_OPTIONS = (
    *("--unit", "codes", "--compression", "positive", "--coding", "offset", "--order", "columns", "--flip-y"),
    *("--skip-columns", "1", "--tare", "lab/rest.csv"),
)

REST = 40  # codes more than half of the range


def recorded(codes: np.ndarray, times: bool = True) -> str:
    """Text of ``codes (n, rows, columns)`` as INPUT has it."""
    lines = []
    for number, frame in enumerate(codes):
        places = [(row, column) for column in range(6) for row in reversed(range(5))]
        cells = [str(8192 + REST - int(frame[place])) for place in places]
        lines.append(";".join([f"{number / 4}".replace(".", ",")] * times + cells) + "\n")
    return "t;" * times + ";".join(f"p{n}" for n in range(30)) + "\n" + "".join(lines)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a CONFIG, its simulated frames on the grid of codes, and the same as a recording in ``lab``."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG)
    assert main(["frames", "skin.toml", "--out", "simulated.npz"]) == 0
    design = load("skin.toml").design
    with np.load("simulated.npz") as archive:
        codes = quantise(design, archive["frames"])
    np.savez("frames.npz", frames=codes * design.adc.lsb)
    Path("lab").mkdir()
    Path("lab/skin.toml").write_text(CONFIG.replace("[[contact]]", INPUT + "[[contact]]", 1))
    Path("lab/frames.csv").write_text(recorded(codes))
    Path("lab/rest.csv").write_text(recorded(np.array([[[-1] * 6] * 5, [[1] * 6] * 5])))
    return tmp_path


def estimate(*arguments: str, out: str = "r.npz") -> dict[str, np.ndarray]:
    assert main(["estimate", *arguments, "--out", out]) == 0
    with np.load(out) as archive:
        assert all(archive[key].dtype != object for key in archive.files)
        return {key: archive[key] for key in archive.files}


@pytest.mark.parametrize("engine", ["float", "fixed"])
def test_config_and_options_read_the_same(engine: str) -> None:
    expected = estimate("skin.toml", "frames.npz", "--engine", engine)
    by_config = estimate("lab/skin.toml", "lab/frames.csv", "--engine", engine)
    whole = Path("r.npz").read_bytes()
    by_options = estimate("skin.toml", "lab/frames.csv", "--engine", engine, *AS_OPTIONS)
    assert whole == Path("r.npz").read_bytes()
    for found in (by_config, by_options):
        for key in (*KEYS, "stress", "config", "engine"):
            np.testing.assert_array_equal(found[key], expected[key])
        assert found["time"].tolist() == [0, 0.25, 0.5]
    assert "time" not in expected


def test_what_frames_wrote_needs_no_input() -> None:
    """But options apply to it, and a copy of it by somebody else is a recording like any other."""
    expected = estimate("skin.toml", "simulated.npz")
    found = estimate("lab/skin.toml", "simulated.npz")
    np.testing.assert_array_equal(found["stress"], expected["stress"])
    flipped = estimate("lab/skin.toml", "simulated.npz", "--flip-x")
    np.testing.assert_array_equal(flipped["stress"], expected["stress"][:, :, ::-1])
    np.savez("copy.npz", frames=expected["stress"])
    assert main(["estimate", "lab/skin.toml", "copy.npz", "--out", "new.npz"]) == 2


def test_result_has_its_config() -> None:
    found = estimate("skin.toml", "frames.npz")
    Path("again.toml").write_text(str(found["config"]))
    first, again = load("skin.toml"), load("again.toml")
    assert again.design == first.design
    assert again.layer == first.layer
    assert found["engine"].shape == found["config"].shape == ()
    assert estimate("again.toml", "frames.npz")["forces"].tobytes() == found["forces"].tobytes()


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_tables(form: str) -> None:
    expected = estimate("lab/skin.toml", "lab/frames.csv")
    assert main(["estimate", "lab/skin.toml", "lab/frames.csv", "--out", f"r.{form}"]) == 0
    assert sorted(path.name for path in Path(f"r.{form}").iterdir()) == [
        f"forces.{form}", f"frames.{form}", "tfra-manifest.json",
    ]  # fmt: skip
    frames, forces = (table(Path(f"r.{form}") / f"{name}.{form}") for name in ("frames", "forces"))
    assert list(frames) == [
        "frame", "time", "phi_deg", "mu", "mu_x", "mu_y", "fx_n", "fy_n", "fz_n", "sweep_index", "status",
    ]  # fmt: skip
    for key in ("time", "phi_deg", "mu", "mu_x", "mu_y", "sweep_index", "status"):
        assert frames[key] == expected[key].tolist()
    assert [frames[key] for key in ("fx_n", "fy_n", "fz_n")] == expected["resultant"].T.tolist()
    assert list(forces) == ["frame", "row", "column", "fx_n", "fy_n", "fz_n"]
    rows = list(zip(*forces.values(), strict=True))
    assert len(rows) == 3 * 5 * 6
    for frame, row, column, *force in rows:
        assert force == expected["forces"][frame, :, row, column].tolist()
    assert len(set(rows)) == len(rows)


def messages(path: str) -> list[tuple[int, dict[str, Any]]]:
    """Times in ns and contents of the messages of forces, as the published schema has them."""
    with open(f"{path}/forces.mcap", "rb") as stream:
        found = list(make_reader(stream, validate_crcs=True).iter_messages(topics=["/forces"]))
    contents = [json.loads(message.data) for _, _, message in found]
    for content, (schema, channel, _) in zip(contents, found, strict=True):
        assert (schema.name, schema.encoding, channel.message_encoding) == ("tfra.Forces", "jsonschema", "json")
        jsonschema.validate(content, json.loads(schema.data) | {"additionalProperties": False})
    return [(message.log_time, content) for (_, _, message), content in zip(found, contents, strict=True)]


def test_messages() -> None:
    expected = estimate("lab/skin.toml", "lab/frames.csv")
    for out in ("r.mcap", "again.mcap"):
        assert main(["estimate", "lab/skin.toml", "lab/frames.csv", "--out", out]) == 0
    assert sorted(path.name for path in Path("r.mcap").iterdir()) == ["forces.mcap", "tfra-manifest.json"]
    assert Path("r.mcap/forces.mcap").read_bytes() == Path("again.mcap/forces.mcap").read_bytes()
    found = messages("r.mcap")
    assert [time for time, _ in found] == [0, 250_000_000, 500_000_000]
    for number, (_, content) in enumerate(found):
        assert content["frame"] == number
        assert list(content["force_n"].values()) == expected["resultant"][number].tolist()
        assert (content["mu"], content["phi_deg"]) == (expected["mu"][number], expected["phi_deg"][number])
        assert list(content["taxels_n"].values()) == expected["forces"][number].tolist()
        assert (content["uncertainty_n"], content["status"]) == (None, [])


def test_messages_at_times_that_mcap_cannot_hold_have_numbers() -> None:
    for first, times in ((-1.0, [0, 10**9]), (1.5e9, [15 * 10**17, 15 * 10**17 + 10**9]), (1.7e13, [0, 10**9])):
        np.savez("late.npz", frames=np.zeros((2, 5, 6)), time=first + np.arange(2))
        assert main(["estimate", "skin.toml", "late.npz", "--out", "late.mcap"]) == 0
        found = messages("late.mcap")
        assert [time for time, _ in found] == times
        assert found[0][1]["status"] == ["NO_CONTACT"]


def test_messages_without_forces_at_the_taxels() -> None:
    frames = np.load("frames.npz")["frames"]
    found = load("skin.toml").design.float_model(frames)
    alone = replace(found, forces=np.full_like(found.forces, np.nan))
    _, _, said = Estimate(Recording(frames), alone, "float", "").messages()
    assert ["taxels_n" in content for content in said] == [False] * 3


def table(path: Path) -> dict[str, list[Any]]:
    """Columns of a table, read by others."""
    read = pl.read_parquet if path.suffix == ".parquet" else pl.read_csv
    return read(path).to_dict(as_series=False)


def test_an_output_is_not_the_tare(capfd: pytest.CaptureFixture[str]) -> None:
    write_npz("rest.npz", {"frames": np.zeros((1, 5, 6))}, "estimate")
    run = ["estimate", "skin.toml", "frames.npz", "--tare", "rest.npz", "--out", "rest.npz"]
    assert refusal(capfd, *run) == "rest.npz: is not replaced: this command reads it: choose another place"


# Options


def test_every_field_is_an_option() -> None:
    assert list(OPTIONS) == list(Input.__dataclass_fields__)


@pytest.mark.parametrize(
    ("chosen", "given", "found"),
    [
        (PLAIN, {}, PLAIN),
        (Input(flip_x=True), {"flip_x": False}, PLAIN),
        (Input(tare=Path("a")), {"tare_frames": 3}, Input(tare_frames=3)),
        (Input(tare=Path("a")), {"tare_frames": 0}, PLAIN),
        (Input(tare_frames=3), {"tare": Path("a")}, Input(tare=Path("a"))),
        (Input(unit="codes", coding="offset"), {"unit": "kPa"}, Input(unit="kPa", coding="offset")),
        (Input(unit="codes"), {"coding": "unipolar"}, Input(unit="codes", coding="unipolar")),
        (Input(skip_columns=2, topic="/a"), {"skip_columns": 0, "topic": "/b"}, Input(topic="/b")),
    ],
)
def test_options_override(chosen: Input, given: dict[str, Any], found: Input) -> None:
    assert overridden(chosen, given) == found
