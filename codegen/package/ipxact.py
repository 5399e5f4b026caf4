"""``NAME_axi.xml``: the wrapper as a component of IP-XACT (IEEE 1685-2014), with buses, registers, ports and files."""

from collections.abc import Iterable
from pathlib import PurePath
from xml.sax.saxutils import escape

from tfra.codegen.package.contents import Contents
from tfra.codegen.registers.files import memory_maps
from tfra.codegen.registers.source import parameters
from tfra.codegen.sidecar.schema import Port
from tfra.codegen.verilog.wrapper import input_bits, ports_of
from tfra.hdl.front_end.ports import NUMBER

_FILES = {".v": "verilogSource", ".sdc": "SDC"}
"""Types of files by their suffixes."""
_PARAMETER = (
    '<ipxact:parameter type="longint"><ipxact:name>{}</ipxact:name><ipxact:value>{}</ipxact:value></ipxact:parameter>'
)


def ipxact(contents: Contents) -> dict[str, str]:
    """The component; its buses are named as in Vivado's catalogue, its parameters are what the registers state."""
    array, ports = contents.array, ports_of(contents.array)
    buses = {bus: "\n".join(_pins(bus, ports)) for bus in ("s_axi", "s_axis", "m_axis")}
    values = parameters(array).items()
    text = contents.fill(
        "component.xml",
        **buses,
        in_bytes=input_bits(array) // 8,
        user_bits=NUMBER,
        memory_maps=memory_maps(array),
        ports="\n".join(map(_port, ports)),
        file_sets="\n".join(_file_sets(contents)),
        text=escape(contents.facts["computes"]),
        parameters="\n".join(_PARAMETER.format(name, value) for name, value in values),
    )
    return {f"{contents.wrapper}.xml": text}


def _pins(bus: str, ports: Iterable[Port]) -> Iterable[str]:
    """Ports of a bus by its names for them."""
    for name in (port.name for port in ports if port.name.startswith(f"{bus}_")):
        logical = _element("logicalPort", name=name.removeprefix(f"{bus}_").upper())
        yield _element("portMap", logical, _element("physicalPort", name=name))


def _port(port: Port) -> str:
    vectors = [_element("vectors", _element("vector", left=port.bits - 1, right=0))] if port.bits > 1 else []
    wire = _element("wire", _element("direction", port.direction), *vectors)
    return _element("port", _element("name", port.name), _element("description", escape(port.note)), wire)


def _file_sets(contents: Contents) -> Iterable[str]:
    """Files of the modules, their constraints, and what simulators need besides."""
    sets = {"rtl": [*contents.rtl, *contents.images]}
    for folder in ("constraints", "testbench"):
        sets[folder] = sorted(name for name in contents.texts if name.startswith(f"{folder}/"))
    for name, files in sets.items():
        kinds = {file: _FILES.get(PurePath(file).suffix, "unknown") for file in files}
        entries = (_element("file", name=file, fileType=kind) for file, kind in kinds.items())
        yield _element("fileSet", _element("name", name), *entries)


def _element(element: str, *children: str, **leaves: object) -> str:
    """An element with texts or elements in it, and ``leaves`` by their names."""
    inner = [*children, *(f"<ipxact:{name}>{value}</ipxact:{name}>" for name, value in leaves.items())]
    return f"<ipxact:{element}>{''.join(inner)}</ipxact:{element}>"
