"""The generated directory: complete, the same every time, and clean in three readers."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from tests.codegen import lint
from tests.marks import long
from tfra.codegen.generate import generate
from tfra.codegen.sidecar.build import LOADED
from tfra.codegen.verilog.emit import run_yosys
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import FORMATS, SERIAL, Architecture, Search
from tfra.model.cover.scenes import directed_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

DESIGNS = {
    "even": TfraDesign(SensorArray(4, 4, 4e-3, 2e-3, 3e-3), "even", search=Search(10), architecture=Architecture(4)),
    "odd": TfraDesign(
        SensorArray(3, 5, 2e-3, 2e-3, 2e-3),
        "odd",
        search=Search(7),
        formats=FORMATS["wide"],
        architecture=Architecture(4),
    ),
}
DESIGNS["serial"] = TfraDesign(SensorArray(2, 3, 4e-3, 2e-3, 3e-3), "serial", search=Search(3), architecture=SERIAL)
DESIGNS["files"] = replace(DESIGNS["even"], name="files", images="readmemh")
DESIGNS["loaded"] = replace(DESIGNS["even"], name="loaded", images="load")
DESIGNS["narrow"] = replace(DESIGNS["even"], name="narrow", architecture=Architecture(4, 1))


@contextmanager
def few_frames():
    """Testbenches with every third directed frame."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tfra.codegen.verilog.testbench.directed_codes", lambda design: directed_codes(design)[::3])
        yield


@pytest.fixture(scope="module", params=["files", "serial", *long("even", "odd", "loaded", "narrow")], name="made")
def _made(request, tmp_path_factory):
    design = DESIGNS[request.param]
    directory = tmp_path_factory.mktemp(design.name) / "core"
    with few_frames():
        generate(design, directory)
    return design, directory


def test_sidecar_tells_what_the_core_is(made):
    design, directory = made
    facts = json.loads((directory / f"{design.name}.json").read_text())
    assert facts["name"] == design.name
    assert facts["latency_cycles"]["first_word"] == microarchitecture(design).latency
    assert facts["result"]["transfers_per_frame"] == design.frame_words
    assert {p["name"]: p["bits"] for p in facts["ports"]}["result_data"] == design.word_bits
    verilog = (directory / f"{design.name}.v").read_text()
    for port in facts["ports"]:
        width = f"[{port['bits'] - 1}:0] " if port["bits"] > 1 else ""
        assert f"{port['direction']}put {width}{port['name']};" in verilog.replace("signed ", "")


@pytest.mark.long
def test_same_bytes_whatever_the_hash_seed(made, tmp_path):
    design, directory = made
    script = (
        "import pathlib, sys\nfrom tests.codegen.test_generate import DESIGNS, few_frames, generate\n"
        "with few_frames():\n    generate(DESIGNS[sys.argv[1]], pathlib.Path(sys.argv[2]))"
    )
    again = tmp_path / "again"
    command = [sys.executable, "-c", script, design.name, str(again)]
    subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": "1234"})
    for file in sorted(p for p in directory.rglob("*") if p.is_file()):
        assert file.read_bytes() == (again / file.relative_to(directory)).read_bytes(), file.name


def test_no_traces_of_this_machine(made):
    _, directory = made
    for file in directory.rglob("*.*"):
        text = file.read_text()
        assert os.getcwd() not in text
        assert "amaranth/" not in text


def test_the_file_to_load_holds_the_coefficients(made):
    design, directory = made
    bits, image = design.formats.coefficient, microarchitecture(design).loaded
    assert (directory / LOADED).exists() == (image is not None)
    if image is not None:
        words = [int(line, 16) for line in (directory / LOADED).read_text().split()]
        signed = [word - (1 << bits) if word >> (bits - 1) else word for word in words]
        np.testing.assert_array_equal(signed, image)


def test_the_sidecar_tells_what_to_load(made):
    design, directory = made
    facts = json.loads((directory / f"{design.name}.json").read_text())
    assert ("load" in facts) == (design in (DESIGNS["serial"], DESIGNS["loaded"]))
    if "load" in facts:
        assert facts["load"]["transfers"] == len((directory / facts["load"]["file"]).read_text().split())
        assert facts["interval_cycles"] == microarchitecture(design).initiation_interval


def test_icarus_reads_it_without_a_word(made):
    design, directory = made
    assert lint.icarus(directory / f"{design.name}.v") == ""


def run_testbench(directory, name, elsewhere=None):
    """What the generated testbench says in Icarus; it runs in the folder ``elsewhere``, which has nothing else."""
    compile_ = ["iverilog", "-g2012", "-Wall", "-Wno-timescale", "-o", "tb", f"{name}.v", f"testbench/{name}_tb.v"]
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


def test_the_testbench_passes(made, tmp_path):
    design, directory = made
    shutil.copytree(directory, tmp_path / "core")
    (tmp_path / "empty").mkdir()
    embedded = design.images != "readmemh"
    said = run_testbench(tmp_path / "core", design.name, tmp_path / "empty" if embedded else None)
    count = int(re.search(r"(\d+) result words", (directory / "testbench" / f"{design.name}_tb.v").read_text())[1])
    assert f"PASSED: {count} words compared, 0 differ" in said
    assert count % design.frame_words == 0


def test_files_beside_the_verilog_are_in_the_sidecar(made):
    design, directory = made
    listed = json.loads((directory / f"{design.name}.json").read_text())["images"]
    assert sorted(i["file"] for i in listed) == sorted(p.name for p in directory.glob("*.hex"))
    assert bool(listed) == (design.images == "readmemh")
    for image in listed:
        lines = (directory / image["file"]).read_text().split()
        assert len(lines) == image["words"]
        assert {len(line) for line in lines} == {-(-image["bits"] // 4)}
        assert max(int(line, 16) for line in lines) < 1 << image["bits"]


@pytest.mark.long
def test_the_testbench_notices_a_wrong_file(tmp_path):
    design = DESIGNS["files"]
    facts = generate(design, tmp_path / "core")
    file = tmp_path / "core" / next(i["file"] for i in facts["images"] if "rom.memory0" in i["file"])
    lines = file.read_text().splitlines()
    lines[0] = f"{int(lines[0], 16) ^ 0x100:0{len(lines[0])}x}"
    file.write_text("\n".join(lines) + "\n")
    assert "FAILED" in run_testbench(tmp_path / "core", design.name)


@pytest.mark.long
def test_the_testbench_notices_a_wrong_load(made, tmp_path):
    design, directory = made
    if design not in (DESIGNS["serial"], DESIGNS["loaded"]):
        return
    shutil.copytree(directory, tmp_path / "core")
    change_word(tmp_path / "core", design.name, "coefficient", 0, 0x4000)
    assert "FAILED" in run_testbench(tmp_path / "core", design.name)


@pytest.mark.parametrize("made", ["files", *long("serial", "even", "odd", "loaded", "narrow")], indirect=True)
def test_the_testbench_notices_a_wrong_word(made, tmp_path):
    design, directory = made
    shutil.copytree(directory, tmp_path / "core")
    change_word(tmp_path / "core", design.name, "result", 2, 1)
    said = run_testbench(tmp_path / "core", design.name)
    assert "1 differ" in said
    assert "FAILED" in said
    assert "word 20" in said


def test_verilator_lints_it_without_a_word(made, tmp_path):
    design, directory = made
    assert lint.verilator(directory / f"{design.name}.v", tmp_path) == ""


def test_yosys_finds_no_problem(made):
    design, directory = made
    run_yosys(f"read_verilog {design.name}.v; hierarchy -check -top {design.name}; proc; check -assert", directory)


def test_an_unwritable_place_leaves_nothing(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(ValueError, match="file"):
        generate(DESIGNS["even"], blocked / "core")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
