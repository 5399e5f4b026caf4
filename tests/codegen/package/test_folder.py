"""The package in the projects of others: Tcl with stand-ins for the tools' commands, FuseSoC, IP-XACT."""

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from tests.codegen.package.made import DESIGNS, PARALLEL, PART, made
from tests.codegen.test_generate import change_word
from tests.marks import long
from tfra.codegen.package.contents import Contents
from tfra.codegen.package.folder import constraints, fusesoc, litex, vivado
from tfra.codegen.package.ipxact import ipxact
from tfra.codegen.registers.source import parameters
from tfra.codegen.sidecar.build import sidecar
from tfra.model.choices import Bus
from tfra.sim.tools import choose, environment

CONTENTS = Contents(PARALLEL, sidecar(PARALLEL) | {"images": []}, {}, PART)

STAND_INS = """
namespace eval ipx { proc unknown args { said $args; return [lindex $args end] }; namespace unknown ::ipx::unknown }
proc unknown args { said $args; return [lindex $args end] }
proc said words { puts [join $words "\\t"] }
"""
"""Any unknown command prints its words and returns the last of them."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scripts of a package, with empty modules."""
    folder = tmp_path_factory.mktemp("tcl")
    texts = {**vivado(CONTENTS), **constraints(CONTENTS), **litex(CONTENTS)}
    for name, text in {**texts, "lanes.v": "", "lanes_axi.v": ""}.items():
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
    registers = CONTENTS.registers.registers
    fields = [field for register in registers for field in register.fields]
    for command, parts in (("register", registers), ("field", fields)):
        assert [words[1] for words in found if words[0] == f"ipx::add_{command}"] == [part.name for part in parts]
    for name, values in {
        "address_offset": [register.address for register in registers],
        "bit_offset": [field.low for field in fields],
        "bit_width": [field.bits for field in fields],
    }.items():
        assert [int(words[2], 0) for words in found if words[:2] == ["set_property", name]] == values
    texts = {words[2] for words in found if words[:2] == ["set_property", "description"]}
    assert texts >= {field.text for field in fields if "{" not in field.text}


def test_vivado_associates_clock_and_reset(folder: Path) -> None:
    found = calls(folder / "vivado" / "package_ip.tcl")
    associated = [words for words in found if words[0] == "ipx::associate_bus_interfaces"]
    assert [words[2] for words in associated if words[1] == "-busif"] == ["s_axi", "s_axis", "m_axis"]
    assert all("aclk" in words for words in associated)
    assert ["ipx::associate_bus_interfaces", "-clock", "aclk", "-reset", "aresetn", associated[0][-1]] in associated
    assert found[-1][0] == "ipx::save_core"


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


@pytest.fixture(scope="module", params=["serial", *long("ice40")])
def package(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    name: str = request.param
    _, folder = made(name, tmp_path_factory.mktemp(name))
    return DESIGNS[name][0].name, folder


def run(targets: str, name: str, package: Path, folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """Run a target, and in the tool behind a space, in ``folder``, which is empty, with a home of its own."""
    target, *tool = targets.split()
    (folder / "tools").mkdir()
    variables = environment("verilator", folder / "tools") | {"HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    program = str(Path(sys.executable).with_name("fusesoc"))
    words = [program, "--cores-root", str(package), "run", *options, "--target", target, f"tfra:core:{name}"]
    words += [word for name in tool for word in ("--tool", name)]
    return subprocess.run(
        words, cwd=folder, env=variables, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )


def test_the_family_chooses_the_tool_and_its_options() -> None:
    """No script for Vivado, which does not know the family's cells."""
    design = replace(PARALLEL, target="ecp5")
    contents = Contents(design, sidecar(design) | {"images": []}, {}, PART)
    (text,) = fusesoc(contents).values()
    assert '"nextpnr_options": ["--25k"' in text
    assert "toplevel: lanes_axi" in text
    assert "description: Synthesis of lanes_axi" in text
    assert vivado(contents) == {}


@pytest.mark.parametrize("target", [*long("sim", "sim_axi", "sim_axi verilator"), "lint"])
def test_the_targets_pass(target: str, package: tuple[str, Path], tmp_path: Path) -> None:
    choose("icarus" if target in ("sim", "sim_axi") else "verilator")
    done = run(target, *package, tmp_path)
    assert done.returncode == 0, done.stdout
    assert "%Warning" not in done.stdout
    assert ("words compared, 0 differ" in done.stdout) == (target != "lint")


def test_the_wrapper_has_one_core_and_modules_of_its_own(package: tuple[str, Path]) -> None:
    name, folder = package
    text = (folder / f"{name}_axi.v").read_text()
    first, *others = re.findall(r"^module (\w+)\(", text, re.M)
    assert first == f"{name}_axi"
    assert all(module.startswith(f"{name}_axi__core") for module in others)
    assert len(re.findall(rf"^  {name} \w+ \($", text, re.M)) == 1


@pytest.mark.parametrize(("target", "seen"), [*long(("sim", "1 differ")), ("lint", "UNDRIVEN")])
def test_what_is_planted_is_found(target: str, seen: str, package: tuple[str, Path], tmp_path: Path) -> None:
    """A wrong word by the simulation, a signal without a driver by the linter."""
    name, folder = package
    shutil.copytree(folder, tmp_path / "package")
    (tmp_path / "run").mkdir()
    file = tmp_path / "package" / f"{name}.v"
    file.write_text(file.read_text().replace("endmodule", "  wire open;\n  wire planted = open;\nendmodule", 1))
    change_word(tmp_path / "package", name, "result", 2, 1)
    done = run(target, name, tmp_path / "package", tmp_path / "run")
    assert done.returncode != 0
    assert seen in done.stdout


def test_synthesis_is_set_up(package: tuple[str, Path], tmp_path: Path) -> None:
    """For the family's tool, which may not be here; nothing is written to the package."""
    name, folder = package
    before = sorted(folder.rglob("*"))
    done = run("synth", name, folder, tmp_path, "--setup")
    assert done.returncode == 0, done.stdout
    assert any(f"{name}.v" in file.read_text(errors="replace") for file in tmp_path.rglob("*.*") if file.is_file())
    assert sorted(folder.rglob("*")) == before


SPACE = "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"
NAMES = {"": SPACE}
PARTS = ("vendor", "library", "name", "version", "busInterfaces", "memoryMaps", "model", "fileSets", "description")
"""Of a component, in the order of IEEE 1685-2014; parameters are the last one."""


@pytest.fixture(scope="module")
def component(package: tuple[str, Path]) -> Element:
    """The package in IP-XACT."""
    name, folder = package
    return ElementTree.parse(folder / f"{name}_axi.xml").getroot()


def texts(root: Element, path: str) -> list[str]:
    return [element.text or "" for element in root.iterfind(path, NAMES)]


def values(root: Element) -> dict[str, str]:
    """Its parameters."""
    names, found = (texts(root, f"parameters/parameter/{key}") for key in ("name", "value"))
    return dict(zip(names, found, strict=True))


def test_the_parts_of_a_component_are_in_the_order_of_the_standard(component: Element) -> None:
    assert [child.tag for child in component] == [f"{{{SPACE}}}{name}" for name in (*PARTS, "parameters")]
    designs = (design for design, _ in DESIGNS.values())
    (design,) = (one for one in designs if texts(component, "name") == [f"{one.name}_axi"])
    assert values(component) == {name: str(value) for name, value in parameters(design).items()}


def ports(root: Element) -> dict[str, tuple[str, int]]:
    """Direction and highest bit of every port."""
    found = root.iterfind("model/ports/port", NAMES)
    keys = ("name", "wire/direction", ".//left")
    rows = [[port.findtext(key, "0", NAMES) for key in keys] for port in found]
    return {name: (way, int(left)) for name, way, left in rows}


def test_ports_are_those_of_the_verilog(component: Element, package: tuple[str, Path]) -> None:
    name, folder = package
    verilog = (folder / f"{name}_axi.v").read_text()
    (module,) = re.findall(rf"^module {name}_axi\(.*?^endmodule", verilog, re.M | re.S)
    expected = re.findall(r"^  (in|out)put (?:\[(\d+):0\] )?(\w+);", module, re.M)
    assert ports(component) == {name: (way, int(left or 0)) for way, left, name in expected}
    assert texts(component, "model//moduleName") == [f"{name}_axi"]


def test_every_port_is_in_one_bus(component: Element) -> None:
    assert sorted(texts(component, "busInterfaces//physicalPort/name")) == sorted(ports(component))
    buses = {bus.findtext("name", "", NAMES): bus for bus in component.iterfind("busInterfaces/busInterface", NAMES)}
    kinds = {name: kind.attrib["name"] for name, bus in buses.items() for kind in bus.iterfind("busType", NAMES)}
    signals = {"aclk": "clock", "aresetn": "reset", "irq": "interrupt"}
    assert kinds == {"s_axi": "aximm", "s_axis": "axis", "m_axis": "axis", **signals}
    assert {name for name, bus in buses.items() if bus.find("master", NAMES) is not None} == {"m_axis", "irq"}
    for name in buses.keys() - signals:
        logical = texts(buses[name], ".//logicalPort/name")
        assert texts(buses[name], ".//physicalPort/name") == [f"{name}_{pin.lower()}" for pin in logical]
    assert values(buses["aclk"]) == {"ASSOCIATED_BUSIF": "s_axi:s_axis:m_axis", "ASSOCIATED_RESET": "aresetn"}
    assert values(buses["aresetn"]) == {"POLARITY": "ACTIVE_LOW"}
    assert values(buses["irq"]) == {"SENSITIVITY": "LEVEL_HIGH"}
    for name in ("s_axis", "m_axis"):
        sizes = [int(values(buses[name])[key]) for key in ("TDATA_NUM_BYTES", "TUSER_WIDTH")]
        assert [8 * sizes[0] - 1, sizes[1] - 1] == [ports(component)[f"{name}_{pin}"][1] for pin in ("tdata", "tuser")]


@pytest.mark.parametrize("taxels", [1, 2, 4])
def test_a_beat_has_two_bytes_a_taxel(taxels: int) -> None:
    array = replace(PARALLEL, bus=Bus(taxels))
    (text,) = ipxact(replace(CONTENTS, array=array)).values()
    (bus,) = (
        one
        for one in ElementTree.fromstring(text).iterfind("busInterfaces/busInterface", NAMES)
        if one.findtext("name", "", NAMES) == "s_axis"
    )
    assert values(bus)["TDATA_NUM_BYTES"] == f"{2 * taxels}"


def test_files_and_registers_are_there(component: Element, package: tuple[str, Path]) -> None:
    (name, folder), root = package, component
    files = texts(root, "fileSets/fileSet/file/name")
    assert {f"{name}.v", f"{name}_axi.v"} | {file.name for file in folder.glob("*.hex")} <= set(files)
    assert all((folder / file).is_file() for file in files)
    assert set(texts(root, ".//fileSetRef/localName")) <= set(texts(root, "fileSets/fileSet/name"))
    (reference,) = (element.attrib["memoryMapRef"] for element in root.iterfind(".//memoryMapRef", NAMES))
    assert [reference] == texts(root, "memoryMaps/memoryMap/name")
