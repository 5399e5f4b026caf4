"""Tcl of the package, run by tclsh with stand-ins for the commands of the tools: what they are asked for."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.codegen.package.made import PARALLEL, PART, made
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.projects import constraints, vivado
from tfra.codegen.registers.source import as_map, compiled
from tfra.codegen.registers.values import parameters
from tfra.codegen.sidecar.build import sidecar
from tfra.codegen.verilog.wrapper import ports_of

STAND_INS = """
namespace eval ipx { proc unknown args { said $args; return [lindex $args end] }; namespace unknown ::ipx::unknown }
proc unknown args { said $args; return [lindex $args end] }
proc said words { puts [join $words "\\t"] }
"""
"""Any unknown command prints its words and returns the last of them."""


@pytest.fixture(scope="module")
def contents() -> Contents:
    return Contents(PARALLEL, sidecar(PARALLEL) | {"images": []}, {}, PART)


@pytest.fixture(scope="module")
def folder(contents: Contents, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scripts of a package, with empty modules."""
    folder = tmp_path_factory.mktemp("tcl")
    for name, text in {**vivado(contents), **constraints(contents), "lanes.v": "", "lanes_axi.v": ""}.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    return folder


def calls(script: Path, more: str = "") -> list[list[str]]:
    """The commands that a script gives, word by word; raises ``AssertionError`` with Tcl's complaint."""
    tclsh = shutil.which("tclsh")
    assert tclsh, "tclsh is missing, please run: sudo apt-get install tcl"
    text = f"{STAND_INS}\n{more}\nsource {script}\n"
    done = subprocess.run([tclsh], input=text, capture_output=True, text=True, check=False)
    assert done.stderr == "", done.stderr
    return [line.split("\t") for line in done.stdout.splitlines()]


def test_vivado_is_told_every_register(folder: Path) -> None:
    found = calls(folder / "vivado" / "package_ip.tcl")
    registers = as_map(compiled(parameters(PARALLEL))).registers
    named = [words[1] for words in found if words[0] == "ipx::add_register"]
    assert named == [register.name for register in registers]
    places = [words[2] for words in found if words[:2] == ["set_property", "address_offset"]]
    assert [int(place, 0) for place in places] == [register.address for register in registers]
    fields = [field for register in registers for field in register.fields]
    assert [words[1] for words in found if words[0] == "ipx::add_field"] == [field.name for field in fields]
    for name, values in (("bit_offset", [f.low for f in fields]), ("bit_width", [f.bits for f in fields])):
        assert [int(words[2]) for words in found if words[:2] == ["set_property", name]] == values
    texts = [words[2] for words in found if words[:2] == ["set_property", "description"]][1:]
    assert {text for text in texts} >= {field.text for field in fields if "{" not in field.text}


def test_vivado_associates_clock_and_reset(folder: Path) -> None:
    found = calls(folder / "vivado" / "package_ip.tcl")
    associated = [words for words in found if words[0] == "ipx::associate_bus_interfaces"]
    assert [words[2] for words in associated if words[1] == "-busif"] == ["s_axi", "s_axis", "m_axis"]
    assert all("aclk" in words for words in associated)
    assert ["ipx::associate_bus_interfaces", "-clock", "aclk", "-reset", "aresetn", associated[0][-1]] in associated
    assert found[-1][0] == "ipx::save_core"
    assert {"aclk", "aresetn", "irq"} <= {pin.name for pin in ports_of(PARALLEL)}


def test_vivado_needs_the_wrapper(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "package")
    (tmp_path / "package" / "lanes_axi.v").unlink()
    with pytest.raises(AssertionError, match=r"lanes_axi\.v is missing"):
        calls(tmp_path / "package" / "vivado" / "package_ip.tcl")


@pytest.mark.parametrize("top", [("aclk", "aresetn"), ("clk", "rst")])
def test_constraints_are_those_of_the_top_module(folder: Path, top: tuple[str, str]) -> None:
    known = "{" + " ".join(top) + "}"
    ports = f"proc get_ports args {{ set name [lindex $args end]; if {{$name in {known}}} {{ return $name }} }}"
    found = calls(folder / "constraints" / "lanes.sdc", ports)
    (clock,) = [words for words in found if words[0] == "create_clock"]
    assert clock[1:3] == ["-name", top[0]]
    assert float(clock[clock.index("-period") + 1]) == pytest.approx(1000 / PART.target.clock_mhz, abs=1e-3)
    assert {words[-1] for words in found if words[0] == "set_multicycle_path"} == {top[1]}


def test_xdc_has_the_same_clock(folder: Path) -> None:
    found = calls(folder / "vivado" / "lanes_axi.xdc", "proc get_ports name { return $name }")
    assert found == [["create_clock", "-name", "aclk", "-period", f"{1000 / PART.target.clock_mhz:.3f}", "aclk"]]


@pytest.mark.long
def test_memory_files_go_with_the_modules(tmp_path: Path) -> None:
    design, package = made("files", tmp_path)
    (package / f"{design.name}_axi.v").write_text("")
    found = calls(package / "vivado" / "package_ip.tcl")
    added = {Path(words[-1]).name for words in found if words[0] == "add_files"}
    assert {file.name for file in package.glob("*.hex")} <= added
