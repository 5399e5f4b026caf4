"""Skins on the command line: frames of several contacts, and the forces of each."""

import csv
import json
import re
from io import StringIO
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader

from tests.cli.test_cli import refusal
from tests.codegen.test_generate import change_word, run_testbench
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.model.converter import quantise
from tfra.model.skin.finding import Mark
from tfra.model.skin.records import decode_records, records
from tfra.model.skin.result import SkinResult, estimate
from tfra.model.tfra import Tfra
from tfra.sim.tools import choose

SKIN = """
[sensor]
rows = 16
columns = 20
pitch_x_mm = 3
pitch_y_mm = 3
thickness_mm = 3

[window]
rows = 6
columns = 6

[[contact]]
shape = "hertz"
center_x_mm = 12
center_y_mm = 21
half_x_mm = 4
half_y_mm = 3
force_n = -4
mu = 0.6
phi_deg = [0, 120, 240]

[[contact]]
shape = "uniform"
center_x_mm = 46
center_y_mm = 21
half_x_mm = 3
half_y_mm = 3
force_n = -2
mu = 0.3
phi_deg = 40
"""


@pytest.fixture
def stress(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    """Frames of the skin in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(SKIN)
    assert main(["frames", "skin.toml", "--out", "frames.npz"]) == 0
    with np.load("frames.npz") as archive:
        assert archive["frame_ref"].tolist() == [0, 0, 1, 1, 2, 2]
        return np.array(archive["frames"])


def test_frames_are_sums(stress: np.ndarray) -> None:
    project = load("skin.toml")
    alone = project.layer.frames(project.array.sensor, project.contacts)
    np.testing.assert_allclose(stress, alone[0::2] + alone[1::2], atol=1e-9)


def of_model(stress: np.ndarray) -> SkinResult:
    """The contacts in double precision."""
    skin = load("skin.toml").skin
    assert skin
    return estimate(skin, stress, Tfra.of(skin.window))


@pytest.mark.parametrize("engine", ["float", "fixed", "c"])
def test_every_engine_finds_the_contacts(stress: np.ndarray, engine: str) -> None:
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "r.npz", "--engine", engine]) == 0
    skin = load("skin.toml").skin
    assert skin
    wanted = of_model(stress)
    if engine != "float":
        words = records(skin, quantise(skin, stress), lambda codes: skin.window.model(codes).words)
        wanted = decode_records(skin, words)
    with np.load("r.npz") as found:
        assert found["frame"].tolist() == [0, 0, 1, 1, 2, 2]
        assert found["contact"].tolist() == [0, 1] * 3
        np.testing.assert_array_equal(found["x_mm"], 1e3 * wanted.x)
        np.testing.assert_array_equal(found["y_mm"], 1e3 * wanted.y)
        np.testing.assert_array_equal(found["resultant"], wanted.windows.resultant)
        np.testing.assert_array_equal(found["forces"], wanted.windows.forces)
        np.testing.assert_array_equal(found["status"], wanted.windows.status)
        np.testing.assert_array_equal(found["stress"], stress)
        assert found["found"].tolist() == [2, 2, 2]
    normal = wanted.windows.resultant[:, 2]
    np.testing.assert_allclose(normal, [-4, -2] * 3, rtol=0.3)


def test_tables_have_a_row_for_each_contact(stress: np.ndarray) -> None:
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "r.csv"]) == 0
    tables = (Path(f"r.csv/{name}.csv").read_text() for name in ("contacts", "frames", "forces"))
    contacts, frames, forces = (list(csv.DictReader(StringIO(text))) for text in tables)
    assert [(row["frame"], row["contact"]) for row in contacts] == [(str(f), str(c)) for f in range(3) for c in (0, 1)]
    assert [(row["frame"], row["found"], row["dropped"]) for row in frames] == [(str(f), "2", "0") for f in range(3)]
    for contact in contacts:
        own = [row for row in forces if (row["frame"], row["contact"]) == (contact["frame"], contact["contact"])]
        assert sum(float(row["fz_n"]) for row in own) == pytest.approx(float(contact["fz_n"]), abs=1e-9)
        assert min(int(row["row"]) for row in own) == int(contact["top"])
        assert min(int(row["column"]) for row in own) == int(contact["left"])


def test_messages_have_every_contact(stress: np.ndarray) -> None:
    """As the published schema has it; the same bytes again."""
    for folder in ("r.mcap", "again.mcap"):
        assert main(["estimate", "skin.toml", "frames.npz", "--out", folder]) == 0
    assert Path("r.mcap/contacts.mcap").read_bytes() == Path("again.mcap/contacts.mcap").read_bytes()
    with open("r.mcap/contacts.mcap", "rb") as stream:
        found = list(make_reader(stream, validate_crcs=True).iter_messages())
    assert [(channel.topic, message.log_time) for _, channel, message in found] == [
        ("/contacts", 10**9 * number) for number in range(3)
    ]
    wanted = of_model(stress)
    for number, (schema, _, message) in enumerate(found):
        content = json.loads(message.data)
        jsonschema.validate(content, json.loads(schema.data))
        assert (content["frame"], content["dropped"], len(content["contacts"])) == (number, 0, 2)
        for contact, place in zip(content["contacts"], np.flatnonzero(wanted.frame == number), strict=True):
            assert list(contact["force_n"].values()) == wanted.windows.resultant[place].tolist()
            assert (contact["x_mm"], contact["mu"]) == (1e3 * wanted.x[place], wanted.windows.mu[place])
            assert ("EDGE" in contact["status"]) == bool(wanted.windows.status[place] & Mark.EDGE)


def test_json_has_the_contacts(stress: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "r.npz", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["frames"] == 3
    assert said["contacts"]["frame"] == [0, 0, 1, 1, 2, 2]
    assert len(said["contacts"]["mu"]) == len(said["contacts"]["x_mm"]) == 6
    assert (said["summary"]["contacts"], said["summary"]["most_in_a_frame"], said["summary"]["dropped"]) == (6, 2, 0)


def test_too_many_contacts_are_dropped_and_told(stress: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    Path("skin.toml").write_text(SKIN + "[contacts]\nmost = 1\n")
    assert main(["estimate", "skin.toml", "frames.npz", "--out", "r.npz"]) == 0
    assert "3 contacts in 3 frames, at most 1 in one; 3 more are dropped" in capsys.readouterr().out


def test_a_skin_at_rest_has_no_contacts(stress: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    np.save("rest.npy", np.zeros((4, 16, 20)))
    for engine in ("float", "fixed"):
        assert main(["estimate", "skin.toml", "rest.npy", "--out", "r.npz", "--engine", engine]) == 0
        out, err = capsys.readouterr()
        assert "0 contacts in 4 frames" in out
        assert "4 of 4 frames have no contact" in err


def test_gates_of_a_skin_are_refused(stress: np.ndarray, capfd: pytest.CaptureFixture[str]) -> None:
    line = "skin.toml: window: tfra verify --netlist takes no skins"
    assert refusal(capfd, "verify", "skin.toml", "--netlist", "ecp5") == line


@pytest.mark.long
def test_its_core_is_verified(stress: np.ndarray, capsys: pytest.CaptureFixture[str]) -> None:
    Path("skin.toml").write_text(SKIN.replace("rows = 6", "rows = 2").replace("columns = 6", "columns = 3"))
    assert main(["verify", "skin.toml", "--simulator", "icarus", "--random", "3", "--page", "page.html", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["passed"], found["kinds"]["given"], found["kinds"]["random"]) == (True, 3, 3)
    assert "Every bit equals the model" in Path("page.html").read_text()


def test_its_c_is_generated(stress: np.ndarray) -> None:
    assert main(["generate", "skin.toml", "--backend", "c", "--out", "core"]) == 0
    assert {"skin.c", "skin_skin.c", "skin_skin.h", "skin_skin_test.c", "skin.json"} <= {
        path.name for path in Path("core").iterdir()
    }


@pytest.mark.long
def test_its_verilog_passes_its_testbench(stress: np.ndarray) -> None:
    """And says so of no other word."""
    choose("icarus")
    assert main(["generate", "skin.toml", "--out", "core"]) == 0
    facts = json.loads(Path("core/skin.json").read_text())
    assert (facts["skin"]["rows"], facts["skin"]["columns"]) == (16, 20)
    assert facts["taxel"]["transfers_per_frame"] == 320
    said = run_testbench(Path("core").absolute(), "skin")
    assert re.search(r"PASSED: \d{4,} words compared, 0 differ", said)
    change_word(Path("core"), "skin", "result", 2, 1)
    assert "1 differ" in run_testbench(Path("core").absolute(), "skin")


def test_what_can_not_be_made_of_a_skin(stress: np.ndarray, capfd: pytest.CaptureFixture[str]) -> None:
    line = "skin.toml: window: tfra generate --backend hls takes no skins"
    assert refusal(capfd, "generate", "skin.toml", "--backend", "hls", "--out", "core") == line


def test_a_package_behind_axi_has_taxels_that_repairs_can_name(
    stress: np.ndarray, capfd: pytest.CaptureFixture[str]
) -> None:
    text = Path("skin.toml").read_text().replace("rows = 16", "rows = 127", 1)
    Path("broad.toml").write_text(text.replace("columns = 20", "columns = 65", 1))
    line = "broad.toml: sensor: up to 8192 taxels are supported with the front end, got 8255"
    assert refusal(capfd, "generate", "broad.toml", "--package", "--out", "core") == line
