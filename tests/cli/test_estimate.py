"""What ``tfra estimate`` says of a recording, and which stress its engines see."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_cli import CONFIG, refusal
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.model.converter import quantise
from tfra.model.tfra import Status, Tfra
from tfra.model.truth import sentence
from tfra.recordings.facts import facts, lines
from tfra.recordings.results import KEYS

CONTACT = """
[[contact]]
shape = "hertz"
half_x_mm = 5
half_y_mm = 4
force_n = -8
mu = 0.6
phi_deg = { start = 0, stop = 360, step = 30 }
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG and its frames."""
    monkeypatch.chdir(tmp_path)
    Path("skin.toml").write_text(CONFIG.partition("[[contact]]")[0] + CONTACT)
    assert main(["frames", "skin.toml", "--out", "frames.npz"]) == 0
    return tmp_path


def run(capsys: pytest.CaptureFixture[str], *options: str, frames: str = "frames.npz") -> tuple[str, str]:
    capsys.readouterr()
    assert main(["estimate", "skin.toml", frames, "--out", "r.npz", *options]) == 0
    said = capsys.readouterr()
    return said.out, said.err


def as_json(capsys: pytest.CaptureFixture[str], *options: str, frames: str = "frames.npz") -> dict[str, Any]:
    content: dict[str, Any] = json.loads(run(capsys, *options, "--json", frames=frames)[0])
    return content


def stress() -> np.ndarray:
    with np.load("frames.npz") as archive:
        return np.array(archive["frames"])


def results() -> dict[str, Any]:
    """What was found, without the stress that it was found in."""
    with np.load("r.npz") as archive:
        return {key: archive[key].tolist() for key in KEYS}


def test_summary(capsys: pytest.CaptureFixture[str]) -> None:
    out, err = run(capsys)
    assert err == ""
    assert max(map(len, out.splitlines())) <= 80
    flat = " ".join(out.split())
    design = load("skin.toml").design
    found = Tfra(design.sensor, 100, 3 * design.adc.lsb)(stress())
    for line in (*lines(facts(stress(), found)), sentence()):
        assert line in flat
    assert out.startswith("12 of 12 frames: contact\n")
    assert out.endswith("r.npz: 12 frames by the float engine, from the file's exact stress\n")


def test_json_has_the_same_facts(capsys: pytest.CaptureFixture[str]) -> None:
    content = as_json(capsys)
    assert content["warnings"] == []
    assert content["friction"] == sentence()
    assert (content["engine"], content["stress"], content["frames"]) == ("float", "exact", 12)
    summary = content["summary"]
    assert (summary["contact"], summary["no_contact"], summary["compression_only"]) == (12, 0, 0)
    assert summary["ranges"]["mu"]["max"] == max(content["mu"])


def test_warnings_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    np.save("kpa.npy", stress() / 1e3)
    capsys.readouterr()
    assert main(["estimate", "skin.toml", "kpa.npy", "--out", "r.npz", "--json"]) == 0
    said = capsys.readouterr()
    doubts = json.loads(said.out)["warnings"]
    assert "was the sensor at rest?" in doubts[0]
    assert "is the unit kPa (times 1000" in doubts[1]
    assert said.err == "".join(f"warning: kpa.npy: {doubt}\n" for doubt in doubts)


def test_a_name_with_a_line_break_is_told_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    np.save("k\npa.npy", stress() / 1e3)
    _, err = run(capsys, frames="k\npa.npy")
    assert len(err.splitlines()) == 2
    assert all(line.startswith("warning: k\\npa.npy: ") for line in err.splitlines())


@pytest.mark.parametrize("engine", ["float", "two-variable"])
def test_codes(capsys: pytest.CaptureFixture[str], engine: str) -> None:
    design = load("skin.toml").design
    np.save("codes.npy", quantise(design, stress()) * design.adc.lsb)
    run(capsys, "--engine", engine, frames="codes.npy")
    on_the_grid = results()
    out, _ = run(capsys, "--engine", engine)
    assert results() != on_the_grid
    out, _ = run(capsys, "--engine", engine, "--codes")
    assert results() == on_the_grid
    line = f"r.npz: 12 frames by the {engine} engine, from codes of the 14-bit converter, 24.4141 Pa each\n"
    assert out.endswith(line)
    assert as_json(capsys, "--engine", engine, "--codes")["stress"] == "codes"


def test_fixed_always_sees_codes(capfd: pytest.CaptureFixture[str]) -> None:
    assert as_json(capfd, "--engine", "fixed")["stress"] == "codes"
    for engine in ("fixed", "rtl"):
        line = f"tfra estimate: --codes: the {engine} engine always sees the converter's codes"
        arguments = ["estimate", "skin.toml", "frames.npz", "--engine", engine, "--codes", "--out", "new.npz"]
        assert refusal(capfd, *arguments) == line


def test_frames_without_contact(capsys: pytest.CaptureFixture[str]) -> None:
    np.save("rest.npy", np.concatenate([np.zeros((1, 5, 6)), np.full((1, 5, 6), 1e4)]))
    content = as_json(capsys, frames="rest.npy")
    assert content["status"][Status.NO_CONTACT.name] == 2
    assert content["summary"]["ranges"] == dict.fromkeys(("phi_deg", "mu", "force_n", "uncertainty_percent"))
