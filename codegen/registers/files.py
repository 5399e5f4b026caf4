"""What drivers and tools need of the registers of a design: C header, page, memory map of IP-XACT."""

import re

from tfra.codegen.registers.source import SOURCE, as_map, compiled, parameters
from tfra.hdl.bus.map import Field, Kind, RegisterMap
from tfra.model.fixed.design import Design
from tfra.model.skin.skin import Skin
from tfra.report.html import Section, page, paragraph
from tfra.report.table import Table
from tfra.runtime.errors import require
from tfra.runtime.scratch import scratch, temporary, writing

VENDOR = "tfra"
"""Vendor and library in the names of IP-XACT."""

_ACCESS = {Kind.PULSE: "W pulse", Kind.PORT: "W", Kind.SETTING: "R/W", Kind.EVENT: "R/W1C"}
"""What software may do; it only reads the other kinds."""

_FIELD = ("bits", "field", "access", "reset", "meaning")


def register_files(array: Design | Skin) -> dict[str, str]:
    """The text of every file by its name, the same for the same design.

    ``registers/tfra.h`` is C99; its names and addresses are those of every design, and the reset values of the
    constants are those of this one.  ``registers/tfra.html`` is one page that loads nothing.

    Raises ``InputError`` without the packages of the extra ``ip``.
    """
    require(SOURCE, "ip", "systemrdl-compiler", "peakrdl-cheader")
    from peakrdl_cheader.c_standards import CStandard
    from peakrdl_cheader.exporter import CHeaderExporter

    top = compiled(parameters(array))
    with scratch(temporary()) as folder, writing(folder.parent):
        # names with the hierarchy, not with the parameters' values, which those of shared types have
        CHeaderExporter().export(top, str(folder / "tfra.h"), std=CStandard.gnu99, reuse_typedefs=False)
        header = (folder / "tfra.h").read_text(encoding="utf-8")
    return {"registers/tfra.h": header, "registers/tfra.html": _page(top.get_property("name"), as_map(top))}


def memory_maps(array: Design | Skin) -> str:
    """The registers as the element ``memoryMaps`` of IP-XACT (IEEE 1685-2014); raises as :func:`register_files`."""
    require(SOURCE, "ip", "systemrdl-compiler", "peakrdl-ipxact")
    from peakrdl_ipxact import IPXACTExporter, Standard

    with scratch(temporary()) as folder, writing(folder.parent):
        exporter = IPXACTExporter(standard=Standard.IEEE_1685_2014)
        exporter.skip_not_present = True  # else it has the registers of other designs, marked, which not all tools heed
        exporter.export(compiled(parameters(array)), str(folder / "tfra.xml"), component_name="tfra")
        text = (folder / "tfra.xml").read_text(encoding="utf-8")
    (found,) = re.findall(r"^  <ipxact:memoryMaps>.*</ipxact:memoryMaps>$", text, re.M | re.S)
    return str(found)


def register_table(registers: RegisterMap) -> Table:
    """A row for every field, in the order of addresses."""
    rows = []
    for register in registers.registers:
        place = (f"0x{register.address:02X}", register.name)
        for field in register.fields:
            rows.append((*place, *_field(field)))
            place = ("", "")
    return Table("Registers", ("address", "register", *_FIELD), rows, (0, 1, 3, 4, 6))


def _page(title: str, registers: RegisterMap) -> str:
    """A page that loads nothing: a section for every register, with its fields."""
    sections = []
    for register in registers.registers:
        fields = Table(f"Fields of {register.name}", _FIELD, [_field(field) for field in register.fields], (1, 2, 4))
        heading = f"0x{register.address:02X} {register.name}"
        sections.append(Section(register.name, heading, [paragraph(register.text), fields.html()]))
    return page(title, [], sections)


def _field(field: Field) -> tuple[str, ...]:
    bits = f"{field.low + field.bits - 1}:{field.low}" if field.bits > 1 else f"{field.low}"
    reset = f"0x{field.reset:X}" if field.reset > 9 else f"{field.reset}"
    return bits, field.name, _ACCESS.get(field.kind, "R"), "–" if field.kind is Kind.STATUS else reset, field.text
