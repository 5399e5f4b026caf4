"""IP-XACT by an XML parser, and the page, against the map of the gateware; compilers see the header with the driver."""

import re
from dataclasses import replace
from html import unescape
from xml.etree import ElementTree

import pytest

from tfra.codegen.registers.files import memory_maps, register_files
from tfra.codegen.registers.source import parameters, register_map
from tfra.hdl.bus.map import Kind
from tfra.model.choices import Architecture
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.runtime import errors as packages
from tfra.runtime.errors import InputError

DESIGN = TfraDesign(SensorArray(3, 2, 4e-3, 4e-3, 3e-3), architecture=Architecture(4))
MAP = register_map(parameters(DESIGN))


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return register_files(DESIGN)


def test_names_are_those_of_every_design(files: dict[str, str]) -> None:
    """Of two designs' headers only reset values differ, so one driver serves both."""
    other = register_files(replace(DESIGN, sensor=SensorArray(2, 4, 4e-3, 4e-3, 3e-3)))["registers/tfra.h"]
    lines = [text.splitlines() for text in (files["registers/tfra.h"], other)]
    differ = [mine for mine, its in zip(*lines, strict=True) if mine != its]
    assert differ
    assert all(re.match(r"#define TFRA__\w+_reset 0x", line) for line in differ)


def test_ipxact() -> None:
    """Places, access and text of every field."""
    space = {"": "ipxact"}
    root = ElementTree.fromstring(f'<map xmlns:ipxact="ipxact">{memory_maps(DESIGN)}</map>')
    found = []
    for register in root.iterfind(".//register", space):
        address = int(register.findtext("addressOffset", "", space).removeprefix("'h"), 16)
        for field in register.iterfind("field", space):
            keys = ("name", "bitOffset", "bitWidth", "access", "modifiedWriteValue", "description")
            name, *values = (field.findtext(key, "", space) for key in keys)
            values[-1] = " ".join(values[-1].split())
            found.append((address, f"{register.findtext('name', '', space)}.{name}", *values))
    access = {Kind.SETTING: "read-write", Kind.EVENT: "read-write", Kind.PULSE: "write-only", Kind.PORT: "write-only"}
    once = {Kind.EVENT: "oneToClear"}
    assert found == [
        (
            *(r.address, f"{r.name}.{f.name}", f"{f.low}", f"{f.bits}"),
            *(access.get(f.kind, "read-only"), once.get(f.kind, ""), f.text),
        )
        for r in MAP.registers
        for f in r.fields
    ]


def test_the_page(files: dict[str, str]) -> None:
    """A section with all texts and places of bits for every register, and nothing that is loaded."""
    page = files["registers/tfra.html"]
    sections = re.findall(r"<section>.*?</section>", page, re.S)
    for section, register in zip(sections, MAP.registers, strict=True):
        assert f'<h2 id="{register.name}">0x{register.address:02X} {register.name}</h2>' in section
        cells = re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", section)
        assert [unescape(cell) for cell in cells[9::5]] == [field.text for field in register.fields]
        for place, field in zip(cells[5::5], register.fields, strict=True):
            *high, low = map(int, place.split(":"))
            assert (low, high) == (field.low, [low + field.bits - 1] if field.bits > 1 else [])
        assert register.text in unescape(section)
    assert not re.search(r"(?:src|href)=\"(?!#|data:)", page)


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packages, "find_spec", lambda name: None if name == "peakrdl_ipxact" else object())
    with pytest.raises(InputError, match=r"peakrdl-ipxact is missing, please run: pip install 'tfra\[ip\]'"):
        memory_maps(DESIGN)
