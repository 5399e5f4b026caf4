"""The generated directory: complete, the same every time, clean in three readers, and checked by its own testbench."""

import os
import re
import shutil
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from bench.scorecard import linters as lint
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design as learned
from tfra.codegen.config.read import load
from tfra.codegen.generate import BACKENDS, Backend, generate
from tfra.codegen.sidecar.build import LOADED
from tfra.codegen.verilog.emit import run_yosys, to_verilog
from tfra.codegen.verilog.testbench import CONTACTS
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import FORMATS, SERIAL, Adc, Architecture, Search
from tfra.model.cover.scenes import directed_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

EXAMPLES = Path(__file__).parents[2] / "examples"
PRESETS = ("fast", "balanced", "small", "learned_fast", "learned_small", "learned_resultant")
SMALL = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
EVEN = TfraDesign(SensorArray(2, 4, 4e-3, 2e-3, 3e-3), "even", search=Search(10), architecture=Architecture(4))
ODD = SensorArray(3, 5, 2e-3, 2e-3, 2e-3)
ONE_LANE = TfraDesign(SMALL, "serial", adc=Adc(8), search=Search(3), architecture=SERIAL)
DESIGNS = {
    "even": EVEN,
    "odd": TfraDesign(ODD, "odd", search=Search(7), formats=FORMATS["wide"], architecture=Architecture(4)),
    "serial": ONE_LANE,
    "serial_files": replace(ONE_LANE, name="serial_files", images="readmemh"),
    "files": replace(EVEN, name="files", images="readmemh"),
    "loaded": replace(EVEN, name="loaded", images="load"),
    "narrow": replace(EVEN, name="narrow", architecture=Architecture(4, 1)),
    "learned": replace(learned(2, 3, adc=Adc(8)), name="learned"),
    "learned_serial": replace(learned(2, 3, adc=Adc(8), architecture=SERIAL), name="learned_serial"),
}


@contextmanager
def few_frames():
    """Testbenches with every third directed frame."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tfra.codegen.verilog.testbench.directed_codes", lambda design: directed_codes(design)[::3])
        yield


@pytest.fixture(
    scope="module",
    params=["serial_files", *long("files", "serial", "odd", "loaded", "learned", "learned_serial")],
    name="core",
)
def _core(request, tmp_path_factory):
    """A design, its directory, the sidecar and the Verilog's file."""
    design = DESIGNS[request.param]
    directory = tmp_path_factory.mktemp(design.name) / "core"
    with few_frames():
        facts = generate(design, directory)
    return design, directory, facts, directory / f"{design.name}.v"


def test_ports_are_those_of_the_sidecar(core):
    _, _, facts, file = core
    verilog = file.read_text()
    (ports,) = re.findall(rf"^module {facts['name']}\(([^)]*)\);", verilog, re.M)
    assert ports.split(", ") == [port["name"] for port in facts["ports"]]
    for port in facts["ports"]:
        width = f"[{port['bits'] - 1}:0] " if port["bits"] > 1 else ""
        assert f"{port['direction']}put {width}{port['name']};" in verilog.replace("signed ", "")


@pytest.mark.long
def test_same_bytes_whatever_the_hash_seed(core, tmp_path):
    design, directory, *_ = core
    script = (
        "import pathlib, sys\nfrom tests.codegen.test_generate import DESIGNS, few_frames, generate\n"
        "with few_frames():\n    generate(DESIGNS[sys.argv[1]], pathlib.Path(sys.argv[2]))"
    )
    again = tmp_path / "again"
    command = [sys.executable, "-c", script, design.name, str(again)]
    subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": "1234"})
    for file in sorted(p for p in directory.rglob("*") if p.is_file()):
        assert file.read_bytes() == (again / file.relative_to(directory)).read_bytes(), file.name


def test_no_traces_of_this_machine(core):
    for file in core[1].rglob("*.*"):
        text = file.read_text()
        assert os.getcwd() not in text
        assert "amaranth/" not in text


def test_the_sidecar_is_indented_for_people(core):
    design, directory, _, _ = core
    lines = (directory / f"{design.name}.json").read_text().splitlines()
    assert lines[0] == "{"
    assert {len(line) - len(line.lstrip()) for line in lines} >= {0, 1, 2, 3}


def test_files_beside_the_verilog_are_in_the_sidecar(core):
    """Coefficients to load, and contents of memories."""
    design, directory, facts, _ = core
    image = microarchitecture(design).loaded
    assert (directory / LOADED).exists() == ("load" in facts) == (image is not None)
    if image is not None:
        words = [int(line, 16) for line in (directory / LOADED).read_text().split()]
        assert words == [int(word) % (1 << design.coefficient_word) for word in image]
        assert (facts["load"]["transfers"], facts["load"]["file"]) == (len(image), LOADED)
    assert sorted(i["file"] for i in facts["images"]) == sorted(p.name for p in directory.glob("*.hex"))
    assert bool(facts["images"]) == (design.images == "readmemh")
    for image in facts["images"]:
        lines = (directory / image["file"]).read_text().split()
        assert len(lines) == image["words"]
        assert {len(line) for line in lines} == {-(-image["bits"] // 4)}
        assert max(int(line, 16) for line in lines) < 1 << image["bits"]


def test_no_name_is_escaped(core):
    _, _, facts, file = core
    text = file.read_text()
    assert "\\" not in text
    modules = re.findall(r"^module (\w+)", text, re.M)
    assert len(modules) == len(set(modules)) > 10
    assert modules[0] == facts["name"]
    assert all(name.startswith(f"{facts['name']}__core") for name in modules[1:])


def test_the_head_tells_what_the_sidecar_does(core):
    _, _, facts, file = core
    lines = file.read_text().partition("\n\n")[0].splitlines()
    assert all(line.startswith("//") and len(line) <= 120 for line in lines)
    head = " ".join(" ".join(lines).replace("//", "").split())
    assert "verilator" not in head.lower()
    latency, fields = facts["latency_cycles"], facts["result"]["fields"]
    for text in (
        *(facts["configuration_sha256"], facts["computes"], *facts["rules"].values()),
        *(f"{port['name']} {port['direction']} {port['bits']} {port['note']}" for port in facts["ports"]),
        *(f"{field['name']} {field['bits']} {field['format']}" for field in fields),
        *(f"{field['name']} {field['meaning']}" for field in fields),
        *(f"{bit['bit']} {bit['name']}: {bit['meaning']}" for bit in facts["result"]["status_bits"]),
        *(f": {cycles}" for cycles in (latency["first_word"], latency["last_word"], facts["interval_cycles"])),
    ):
        assert text in head


def test_linters_and_yosys_are_silent(core, tmp_path):
    design, directory, _, file = core
    assert lint.verilator(file, tmp_path) == ""
    assert lint.icarus(file) == ""
    run_yosys(f"read_verilog {file.name}; hierarchy -check -top {design.name}; proc; check -assert", directory)


@pytest.mark.long
@pytest.mark.parametrize("preset", PRESETS)
def test_linters_are_silent_about_the_presets(preset, tmp_path):
    design = load(EXAMPLES / f"{preset}.toml").design
    file = tmp_path / f"{design.name}.v"
    file.write_text(to_verilog(design))
    models = microarchitecture(design).cell_models
    assert lint.verilator(file, tmp_path, models) == ""
    assert lint.icarus(file, *models) == ""


PLANTED = {
    "UNDRIVEN": ("endmodule", "wire dangling_in; wire unused_out; assign unused_out = dangling_in;\nendmodule"),
    "PROCASSINIT": ("endmodule", "reg unused_out = 0; always @(posedge clk) unused_out <= rst;\nendmodule"),
    "SELRANGE": ("endmodule", "wire unused_out = taxel_data[99];\nendmodule"),
    "PINMISSING": ("    .i__valid(taxel_valid),\n", ""),
}


@pytest.mark.parametrize("core", ["serial_files"], indirect=True)
@pytest.mark.parametrize("rule", PLANTED)
def test_linters_find_what_is_planted(rule, core, tmp_path):
    planted = tmp_path / core[3].name
    planted.write_text(core[3].read_text().replace(*PLANTED[rule], 1))
    assert f"%Warning-{rule}:" in lint.verilator(planted, tmp_path)
    assert ("i__valid" in lint.icarus(planted)) == (rule == "PINMISSING")


def run_testbench(directory, name, elsewhere=None):
    """What the generated testbench says by the command in its head; it runs in the empty folder ``elsewhere``."""
    text = (directory / f"testbench/{name}_tb.v").read_text()
    (command,) = re.findall(r"^// (iverilog .*) && vvp -n tb$", text, re.M)
    compile_ = [*command.split(), "-Wall", "-Wno-timescale"]
    done = subprocess.run(compile_, cwd=directory, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    command = ["vvp", "-n", str(directory / "tb")]
    done = subprocess.run(command, cwd=elsewhere or directory, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == ("PASSED" in done.stdout)
    return done.stdout


def change_word(directory, name, kind, place, change):
    """Plant ``change`` in a word of the testbench: the first of the ``place``-th line of its ``kind``."""
    file = directory / "testbench" / f"{name}_tb.v"
    lines = file.read_text().splitlines(keepends=True)
    number = [n for n, line in enumerate(lines) if line.startswith(f"      {kind}(")][place]
    head, digits = lines[number].split("'h", 1)
    first = digits.partition("_")[0]
    lines[number] = f"{head}'h{int(first, 16) ^ change:0{len(first)}x}{digits[len(first) :]}"
    file.write_text("".join(lines))


def test_the_testbench_passes(core, tmp_path):
    design, directory, *_ = core
    shutil.copytree(directory, tmp_path / "core")
    (tmp_path / "empty").mkdir()
    embedded = design.images != "readmemh"
    output = run_testbench(tmp_path / "core", design.name, tmp_path / "empty" if embedded else None)
    frames = len(directed_codes(design)[::3]) + CONTACTS
    assert f"PASSED: {frames * design.frame_words} words compared, 0 differ" in output


@pytest.mark.long
@pytest.mark.parametrize(("name", "target"), [("serial", "ice40"), ("even", "ecp5")])
def test_models_of_cells_are_beside_the_testbench(name, target, tmp_path):
    design = replace(DESIGNS[name], target=target)
    with few_frames():
        generate(design, tmp_path / "core")
    models = {file.name for file in microarchitecture(design).cell_models}
    assert models
    assert {file.name for file in (tmp_path / "core" / "testbench").iterdir()} == {f"{name}_tb.v", *models}
    assert "0 differ" in run_testbench(tmp_path / "core", name)


@pytest.mark.parametrize("core", ["serial_files", *long("files", "odd", "loaded")], indirect=True)
def test_the_testbench_notices_a_wrong_word(core, tmp_path):
    design, directory, *_ = core
    shutil.copytree(directory, tmp_path / "core")
    change_word(tmp_path / "core", design.name, "result", 2, 1)
    output = run_testbench(tmp_path / "core", design.name)
    assert all(text in output for text in ("1 differ", "FAILED", "word 20"))


@pytest.mark.long
@pytest.mark.parametrize("core", ["files", "serial", "loaded"], indirect=True)
def test_the_testbench_notices_a_wrong_coefficient(core, tmp_path):
    design, directory, facts, _ = core
    shutil.copytree(directory, tmp_path / "core")
    if design.images == "readmemh":
        file = tmp_path / "core" / next(image["file"] for image in facts["images"] if "rom" in image["file"])
        lines = file.read_text().splitlines()
        lines[0] = f"{int(lines[0], 16) ^ 0x100:0{len(lines[0])}x}"
        file.write_text("\n".join(lines) + "\n")
    else:
        change_word(tmp_path / "core", design.name, "coefficient", 0, 0x4000)
    assert "FAILED" in run_testbench(tmp_path / "core", design.name)


def test_an_unwritable_place_leaves_nothing(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(ValueError, match="file"):
        generate(DESIGNS["even"], blocked / "core")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_scripts_may_be_run_by_everybody(tmp_path, monkeypatch):
    monkeypatch.setitem(BACKENDS, "scripts", Backend(lambda array: {f"{array.name}.json": "{}", "run.sh": "true\n"}))
    generate(DESIGNS["even"], tmp_path / "core", backend="scripts")
    assert (tmp_path / "core" / "run.sh").stat().st_mode & 0o777 == 0o755
