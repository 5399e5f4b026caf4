"""``tfra synth`` and ``tfra size``: what is printed and written, exit codes, one line for bad input."""

import json
import re
import signal
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.cli.test_cli import refusal
from tests.marks import long
from tfra.cli import common
from tfra.cli.main import main
from tfra.codegen.config.read import load
from tfra.codegen.verilog.files import fingerprint
from tfra.families import TARGETS, Target, find
from tfra.hdl.cores import microarchitecture
from tfra.hdl.ip.wrapper import cut_through, interval, latencies
from tfra.model.fixed.design import Design
from tfra.runtime.ownership import MANIFEST
from tfra.runtime.processes import Stopped
from tfra.synth import run as flow
from tfra.synth.estimate import estimate
from tfra.synth.flow import CriticalPath, Route, Synthesis
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


def once(make: Callable[..., Any]) -> Callable[..., Any]:
    """The same, made once for each design and each part or family: elaborating takes seconds."""
    made: dict[tuple[Any, ...], Any] = {}

    def get(design: Design, *where: Any, **options: Any) -> Any:
        key = design, *(each.name for each in where), *options.values()
        if key not in made:
            made[key] = make(design, *where, **options)
        return made[key]

    return get


ESTIMATE, MODULES = once(estimate), once(flow.modules)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a CONFIG; tools that answer at once."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TFRA_CACHE", str(tmp_path / "cache"))  # the tools' answers are not true
    Path("skin.toml").write_text(CONFIG)

    def synthesise(modules: dict[str, str], target: Target, directory: Path) -> Synthesis:
        (directory / "netlist.json").write_text("{}")
        assert all(f"\nmodule {file.removesuffix('.v')}(" in text for file, text in modules.items())
        return Synthesis(dict.fromkeys(target.resources, 3), {"LUT4": 3}, "default")

    def route(target: Target, directory: Path, seed: int, clock_mhz: float) -> Route:
        (directory / f"seed{seed}.layout").write_text("")
        used = dict.fromkeys(target.family.place_and_route.bels, 4)
        return Route(seed, clock_mhz - seed, used, CriticalPath("gain", "phi", "a", "b", 1.0, 2.0))

    def pack(target: Target, directory: Path, seed: int, name: str) -> str:
        (directory / f"{name}.bit").write_text(str(seed))
        return f"{name}.bit"

    stand_ins = {"synthesise": synthesise, "route": route, "pack": pack, "estimate": ESTIMATE, "modules": MODULES}
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(flow, name, stand_in)
    return tmp_path


def test_synth(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(common, "INTERVAL", 0)
    assert main(SYNTH) == 0
    said = capsys.readouterr()
    assert said.out == Path("fpga/report.txt").read_text()
    steps = ["yosys", *(f"place and route, seed {seed}" for seed in (1, 2, 3)), "bitstream"]
    assert list(dict.fromkeys(line.split(": ")[0] for line in said.err.splitlines())) == steps
    assert all(re.search(r": \d+ %, about \d+ \w+ left$", line) for line in said.err.splitlines())
    files = ["index.html", "report.json", "report.txt", "skin.bit", MANIFEST]
    assert sorted(path.name for path in Path("fpga").iterdir()) == files
    found = json.loads(Path("fpga/report.json").read_text())
    assert found["clock"]["median_mhz"] == CLOCK - 2
    assert Path("fpga/skin.bit").read_text() == "2"
    assert main([*SYNTH, "--seeds", "1", "--clock-mhz", "90", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json.loads(Path("fpga/report.json").read_text())
    assert found["clock"]["seeds"] == [{"seed": 1, "mhz": 89.0}]
    assert found["resources"]["LUT"]["used"] == 4
    entries = [path.name for path in Path("cache").iterdir() if re.search("[0-9a-f]{16}$", path.name)]
    assert {name.partition("-")[0] for name in entries} == {"yosys", "route"}  # which the cache's limit holds for


@pytest.mark.long
def test_a_skin(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The core of its window and what is around it."""
    sensor = CONFIG.replace("rows = 2", "rows = 5").replace("columns = 2", "columns = 6")
    Path("skin.toml").write_text(f"{sensor}\n[window]\nrows = 2\ncolumns = 2\n[contacts]\nmost = 3\n")
    assert main([*SYNTH, "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["timing"]["contacts"] == 3
    assert "finding" in found["estimated_blocks"]
    assert main([*SIZE, "--frames-per-second", "1e4", "--latency-us", "1e4", "--json"]) == 0
    chosen = json.loads(capfd.readouterr().out)
    assert chosen["frames_per_second"] == pytest.approx(1e6 * CLOCK / chosen["interval"])


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
    assert "tfra synth: finished steps are kept: the same command continues after them\n" in said.err
    assert not Path("fpga").exists()
    monkeypatch.setattr(flow, "synthesise", None)
    assert main([*SYNTH, "--json"]) == 0
    assert seeds == [1, 2, 2, 3]
    found = json.loads(capsys.readouterr().out)
    assert (found["complete"], found["clock"]["median_mhz"]) == (True, CLOCK - 2)


@pytest.mark.long
def test_behind_its_buses(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The package's module with the core inside: one clock, no port of many bits, latency from stream to stream."""
    assert main([*SYNTH, "--package", "--seeds", "1", "--json"]) == 0
    found, design = json.loads(capsys.readouterr().out), load("skin.toml").design
    core = microarchitecture(design)
    assert found["name"] == "skin_axi"
    times = [found["timing"][f"{name}_cycles"] for name in ("latency", "frame_latency", "interval")]
    assert times == [*latencies(core)[:2], interval(core)]
    assert times[0] > core.latency + design.sensor.taxels
    assert found["timing"]["cut_through_cycles"] == cut_through(core)[0]
    assert "CONTROL.cut_through" in Path("fpga/report.txt").read_text()
    modules = MODULES(design, package=True, pins=True)
    assert found["netlist"] == fingerprint([modules["skin.v"], "// a comment\n" + modules["skin_axi.v"]])
    assert list(modules) == ["skin.v", "skin_axi.v", "skin_axi_pins.v"]
    top = modules["skin_axi_pins.v"].partition("module skin_axi_pins(")[2]
    ports = set(re.findall(r"^  (?:input|output) (\w+);$", top, re.M))
    assert set(re.split(r"\W+", top.partition(");")[0])) == ports > {"shift", "clk", "rst", "irq"}
    assert not {"aclk", "aresetn"} & ports


def test_a_missing_tool(folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    part = find("ecp5-85")
    tool = replace(part.family.place_and_route, program="yowasp-nextpnr-mars")
    absent = replace(part, family=replace(part.family, place_and_route=tool))
    monkeypatch.setitem(TARGETS, part.name, absent)
    assert refusal(capfd, *SYNTH) == "yowasp-nextpnr-mars: is not installed: pip install 'tfra[synth]'"


def test_a_serial_core(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("serial.toml").write_text(CONFIG.replace("mac_lanes = 4", 'kind = "serial"\n[target]\nname = "ice40"'))
    assert main(["synth", "serial.toml", "--target", "ice40up5k", "--out", "fpga"]) == 0
    assert "serial on ice40up5k: serial core, 3 MAC lanes" in capsys.readouterr().out
    assert Path("fpga/serial.bit").is_file()


def test_cells_of_another_family(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    Path("skin.toml").write_text(CONFIG + '[target]\nname = "ice40"\n')
    assert refusal(capfd, *SYNTH) == "skin.toml: target.name: ecp5-85-6 has no cells of ice40"


SMALL = ("--frames-per-second", "100", "--latency-us", "1e5")
FAST = ("--frames-per-second", "1e5", "--latency-us", "50")


def test_size(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is printed is TOML that the same CONFIG can have, and the core that it makes is as fast as it says."""
    assert main([*SIZE, *FAST]) == 0
    text = capsys.readouterr().out
    first, *comments = text.partition("# ")[2].splitlines()
    assert tomllib.loads(text) == {"architecture": {"kind": "parallel", "mac_lanes": 4, "vector_words": 1}}
    assert first.startswith(f"ecp5-85-6 at {CLOCK:g} MHz: ")
    assert comments.pop(0) == "# 98 MHz: the aim of place and route; no parallel core was measured on ecp5-85-6"
    assert comments[0].startswith("# estimated: ")
    assert " of 83,640 LUT (2" in comments[0]
    starts = ("at most, if as", "a LUT is a LUT4 of ECP5; fitted to", "power, an estimate: ", "ecp5-85: 30 to 100 EUR")
    assert all(line.startswith(f"# {start}") for line, start in zip(comments[1:5], starts, strict=True))
    assert comments[5] == "# not chosen:"
    assert [line.split(": ")[:2] for line in comments[6:]] == [
        ["#   serial", "too slow"],
        ["#   parallel, 4 lanes, 2 words", "larger"],
        ["#   parallel, 4 lanes, 4 words", "larger"],
    ]
    Path("sized.toml").write_text(CONFIG.partition("[architecture]")[0] + text)
    core = microarchitecture(load("sized.toml").design)
    fps, latency = re.findall(r"([\d,.]+) (?:frames/s|us from)", first)
    assert fps == f"{1e6 * CLOCK / core.initiation_interval:,.0f}"
    assert latency == f"{core.frame_latency / CLOCK:.3f}"


@pytest.mark.long
def test_size_in_the_guide(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The command and the answer that docs/synth.md shows."""
    root = Path(__file__).parents[2]
    monkeypatch.chdir(root)
    page = (root / "docs" / "synth.md").read_text().partition("## Sizing\n")[2]
    (command,) = re.findall(r"^    tfra (.+)$", page, re.MULTILINE)
    (answer,) = re.findall(r"<!-- sized -->\n```toml\n(.+?)```\n<!-- end sized -->", page, re.DOTALL)
    assert main(command.split()) == 0
    assert capsys.readouterr().out == answer


@pytest.mark.parametrize(
    ("architecture", "images"), long(('kind = "serial"', {}), ("mac_lanes = 4", {"images": "inline"}))
)
def test_size_of_a_serial_core(
    folder: Path, capsys: pytest.CaptureFixture[str], architecture: str, images: dict[str, str]
) -> None:
    """Whatever CONFIG's architecture is, on a part that needs cells which CONFIG does not ask for."""
    asked = CONFIG.replace("mac_lanes = 4", architecture)
    Path("skin.toml").write_text(asked + '[target]\nimages = "load"\n' if images else asked)
    assert main(["size", "skin.toml", "--target", "ice40up5k", *SMALL]) == 0
    printed = capsys.readouterr().out
    assert tomllib.loads(printed) == {"architecture": {"kind": "serial"}, "target": {"name": "ice40", **images}}
    assert "# a LUT is a logic cell of iCE40; fitted to syntheses of serial cores for iCE40, off by " in printed
    assert "# not chosen:\n#   parallel, 4 lanes, 1 word: LUT: about " in printed


def test_size_in_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["size", "skin.toml", "--target", "xc7", *SMALL, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["kind"], found["mac_lanes"], found["clock_mhz"]) == ("serial", 0, 100.0)
    assert found["frames_per_second"] == pytest.approx(1e8 / found["interval"])
    assert found["config"] == {"architecture": {"kind": "serial"}}
    assert (found["fitted_to"], found["relative_error"], found["available"]) == ("ice40", None, {})
    others = [(each["kind"], each["mac_lanes"], each["vector_words"]) for each in found["others"]]
    assert others == [("parallel", 4, 1), ("parallel", 4, 2), ("parallel", 4, 4)]
    assert all(each["estimated"]["LUT"] > found["estimated"]["LUT"] for each in found["others"])
    assert all(each["why"].startswith("larger: ") for each in found["others"])


def test_size_of_words_that_overflow(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Whatever core CONFIG asks for: no core has such words."""
    for kind in ("mac_lanes = 4", 'kind = "serial"'):
        text = CONFIG.replace("mac_lanes = 4", kind).replace("= 2", "= 10").replace("mm = 4", "mm = 1")
        Path("fine.toml").write_text(text + '[formats]\nname = "wide"\n')
        said = refusal(capfd, "size", "fine.toml", "--target", "xc7", *SMALL)
        assert said.startswith("fine.toml: formats: ")
        assert refusal(capfd, "generate", "fine.toml", "--out", "core") == said


def test_size_on_all_parts(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A table, the facts and a page; two parts stand for all."""
    monkeypatch.setattr("tfra.synth.size.parts", lambda: [find("ecp5-25"), find("ice40up5k")])
    assert main(["size", "skin.toml", "--target", "all", *SMALL, "--page", "parts.html"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if "serial" in line]
    assert [row[1:6:2] for row in rows] == [["ecp5-25-6,", "serial", "98*"], ["ice40up5k,", "serial", "26.54"]]
    assert "2 of 2 parts have a core" in Path("parts.html").read_text()
    assert main(["size", "skin.toml", "--target", "all", *SMALL, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["parts"]
    assert [each["config"].get("target") for each in found] == [None, {"name": "ice40"}]


def test_size_on_no_part(folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("tfra.synth.size.parts", lambda: [find("ice40up5k"), find("ecp5-25")])
    asked = ("--frames-per-second", "1e9", "--latency-us", "1e5", "--page", "parts.html")
    said = refusal(capfd, "size", "skin.toml", "--target", "all", *asked)
    assert said.startswith("skin.toml: no part has such a core: on ecp5-25-6, frames_per_second: 1e+09 are wanted, ")
    assert not Path("parts.html").exists()
