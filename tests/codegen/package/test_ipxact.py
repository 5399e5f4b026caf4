"""The component of IP-XACT has the ports of the Verilog, each in one bus, and all files that it names are there."""

import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from tests.codegen.package.made import DESIGNS, made
from tests.marks import long
from tfra.codegen.registers.source import parameters
from tfra.model.fixed.design import Design

SPACE = "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"
NAMES = {"": SPACE}
ORDER = ("vendor", "library", "name", "version", "busInterfaces", "memoryMaps", "model", "fileSets", "description")
"""Of the parts in IEEE 1685-2014; parameters are the last one."""


@pytest.fixture(scope="module", params=["serial", *long(*(name for name in DESIGNS if name != "serial"))])
def component(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, Path, Element]:
    design, folder = made(request.param, tmp_path_factory.mktemp(request.param))
    return design, folder, ElementTree.parse(folder / f"{design.name}_axi.xml").getroot()


def texts(root: Element, path: str) -> list[str]:
    return [element.text or "" for element in root.iterfind(path, NAMES)]


def values(root: Element) -> dict[str, str]:
    """Its parameters."""
    names, found = (texts(root, f"parameters/parameter/{key}") for key in ("name", "value"))
    return dict(zip(names, found, strict=True))


def test_its_parts_are_in_the_order_of_the_standard(component: tuple[Design, Path, Element]) -> None:
    design, _, root = component
    assert [child.tag for child in root] == [f"{{{SPACE}}}{name}" for name in (*ORDER, "parameters")]
    assert values(root) == {name: str(value) for name, value in parameters(design).items()}


def ports(root: Element) -> dict[str, tuple[str, int]]:
    """Direction and highest bit of every port."""
    found = root.iterfind("model/ports/port", NAMES)
    keys = ("name", "wire/direction", ".//left")
    rows = [[port.findtext(key, "0", NAMES) for key in keys] for port in found]
    return {name: (way, int(left)) for name, way, left in rows}


def test_ports_are_those_of_the_verilog(component: tuple[Design, Path, Element]) -> None:
    design, folder, root = component
    verilog = (folder / f"{design.name}_axi.v").read_text()
    (module,) = re.findall(rf"^module {design.name}_axi\(.*?^endmodule", verilog, re.M | re.S)
    expected = re.findall(r"^  (in|out)put (?:\[(\d+):0\] )?(\w+);", module, re.M)
    assert ports(root) == {name: (way, int(left or 0)) for way, left, name in expected}
    assert texts(root, "model//moduleName") == [f"{design.name}_axi"]


def test_every_port_is_in_one_bus(component: tuple[Design, Path, Element]) -> None:
    *_, root = component
    assert sorted(texts(root, "busInterfaces//physicalPort/name")) == sorted(ports(root))
    buses = {bus.findtext("name", "", NAMES): bus for bus in root.iterfind("busInterfaces/busInterface", NAMES)}
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
        assert [8 * sizes[0] - 1, sizes[1] - 1] == [ports(root)[f"{name}_{pin}"][1] for pin in ("tdata", "tuser")]


def test_files_and_registers_are_there(component: tuple[Design, Path, Element]) -> None:
    design, folder, root = component
    files = texts(root, "fileSets/fileSet/file/name")
    assert {f"{design.name}.v", f"{design.name}_axi.v"} | {file.name for file in folder.glob("*.hex")} <= set(files)
    assert all((folder / file).is_file() for file in files)
    assert set(texts(root, ".//fileSetRef/localName")) <= set(texts(root, "fileSets/fileSet/name"))
    (reference,) = (element.attrib["memoryMapRef"] for element in root.iterfind(".//memoryMapRef", NAMES))
    assert [reference] == texts(root, "memoryMaps/memoryMap/name")
