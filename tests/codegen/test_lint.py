"""Linters find nothing in the generated Verilog, and find what is planted in it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.codegen import lint
from tests.marks import long
from tests.model.fixed.learned.cases import learned_design
from tfra.codegen.config.read import load
from tfra.codegen.verilog.files import files
from tfra.hdl.cores import microarchitecture
from tfra.model.choices import SERIAL, Adc, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

EXAMPLES = Path(__file__).parents[2] / "examples"
PRESETS = ("fast", "balanced", "small", "learned_fast", "learned_small")
SENSOR = SensorArray(2, 3, 4e-3, 2e-3, 3e-3)
DESIGNS: dict[str, Design] = {
    "serial": TfraDesign(SENSOR, "serial", adc=Adc(8), search=Search(3), architecture=SERIAL),
    "learned_serial": replace(learned_design(2, 3, adc=Adc(8), architecture=SERIAL), name="learned_serial"),
    "learned_parallel": replace(learned_design(2, 3, adc=Adc(8)), name="learned_parallel"),
    "parallel": TfraDesign(SENSOR, "parallel", adc=Adc(8), search=Search(3), architecture=Architecture(4)),
}


@pytest.fixture(
    scope="module", params=["serial", "learned_serial", *long("learned_parallel", "parallel")], name="core"
)
def _core(request, tmp_path_factory):
    """The sidecar, and the file of the Verilog."""
    return write(DESIGNS[request.param], tmp_path_factory.mktemp(request.param))


def write(design, folder):
    texts = files(design)
    file = folder / f"{design.name}.v"
    file.write_text(texts[file.name])
    return json.loads(texts[f"{design.name}.json"]), file


def test_linters_are_silent(core, tmp_path):
    _, file = core
    assert lint.verilator(file, tmp_path) == ""
    assert lint.icarus(file) == ""


PLANTED = {
    "UNDRIVEN": "wire dangling_in; wire unused_out; assign unused_out = dangling_in;",
    "PROCASSINIT": "reg unused_out = 0; always @(posedge clk) unused_out <= rst;",
    "UNSIGNED": "wire unused_out; assign unused_out = taxel_data[1:0] < 2'd0;",
}


@pytest.mark.parametrize("core", ["serial"], indirect=True)
@pytest.mark.parametrize("rule", PLANTED)
def test_verilator_finds_what_is_planted(rule, core, tmp_path):
    _, file = core
    planted = tmp_path / file.name
    planted.write_text(file.read_text().replace("endmodule", f"{PLANTED[rule]}\nendmodule", 1))
    assert f"%Warning-{rule}:" in lint.verilator(planted, tmp_path)


@pytest.mark.parametrize("core", ["serial"], indirect=True)
def test_a_missing_pin_is_found_by_both(core, tmp_path):
    _, file = core
    planted = tmp_path / file.name
    planted.write_text(file.read_text().replace("    .i__valid(taxel_valid),\n", "", 1))
    assert "PINMISSING" in lint.verilator(planted, tmp_path)
    assert "i__valid" in lint.icarus(planted)


def test_no_name_is_escaped(core):
    facts, file = core
    text = file.read_text()
    assert "\\" not in text
    modules = re.findall(r"^module (\w+)", text, re.M)
    assert len(modules) == len(set(modules)) > 10
    assert modules[0] == facts["name"]
    assert all(name.startswith(f"{facts['name']}__core") for name in modules[1:])


def test_ports_have_the_order_of_the_sidecar(core):
    facts, file = core
    (ports,) = re.findall(rf"^module {facts['name']}\(([^)]*)\);", file.read_text(), re.M)
    assert ports.split(", ") == [port["name"] for port in facts["ports"]]


def test_the_head_tells_what_the_sidecar_does(core):
    facts, file = core
    lines = file.read_text().partition("\n\n")[0].splitlines()
    assert all(line.startswith("//") and len(line) <= 120 for line in lines)
    head = " ".join(line[2:].strip() for line in lines)
    assert all(text in head for text in (facts["configuration_sha256"], facts["computes"], *facts["rules"].values()))
    assert "verilator" not in head.lower()
    words = [line.split()[1:] for line in lines]
    for port in facts["ports"]:
        assert [port["name"], port["direction"], str(port["bits"]), *port["note"].split()] in words
    for field in facts["result"]["fields"]:
        assert any(line[1:2] == [field["name"]] and field["format"] in line for line in words)
        assert [field["name"], *field["meaning"].split()] in words
    for bit in facts["result"]["status_bits"]:
        assert [str(bit["bit"]), f"{bit['name']}:", *bit["meaning"].split()] in words
    latency = facts["latency_cycles"]
    for cycles in (latency["first_word"], latency["last_word"], facts["interval_cycles"]):
        assert re.search(rf": {cycles}\b", head), cycles


def test_the_hash_covers_every_choice():
    """Any other choice, coefficient or kind of image gives another hash."""
    from tfra.codegen.sidecar.build import sidecar

    first = DESIGNS["serial"]
    others = [
        replace(first, name="other"),
        replace(first, adc=Adc(9)),
        replace(first, search=Search(7)),
        replace(first, sensor=replace(SENSOR, thickness=2.5e-3)),
        replace(first, target="ice40"),
        replace(first, images="readmemh"),
    ]
    hashes = [sidecar(design)["configuration_sha256"] for design in (first, *others)]
    assert len(set(hashes)) == len(hashes)
    assert sidecar(replace(first))["configuration_sha256"] == hashes[0]


@pytest.mark.long
@pytest.mark.parametrize("target", ["its own", "portable"])
@pytest.mark.parametrize("preset", PRESETS)
def test_linters_are_silent_about_the_presets(preset, target, tmp_path):
    design = load(EXAMPLES / f"{preset}.toml").design
    design = design if target == "its own" else replace(design, target=target)
    _, file = write(design, tmp_path)
    models = microarchitecture(design).cell_models
    rules = [model.with_name("cells.vlt") for model in models[:1]]
    assert lint.verilator(file, tmp_path, models, rules) == ""
    assert lint.icarus(file, *models) == ""
