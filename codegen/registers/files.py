"""What drivers and tools need of the registers of a design: C header, page, IP-XACT."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tfra.codegen.registers.source import SOURCE, as_map, compiled
from tfra.codegen.registers.table import register_page
from tfra.codegen.registers.values import parameters
from tfra.model.fixed.design import Design
from tfra.runtime.extras import require
from tfra.runtime.scratch import scratch, temporary, writing

if TYPE_CHECKING:
    from systemrdl.node import AddrmapNode

VENDOR = "tfra"
"""Vendor and library in the names of IP-XACT."""


def register_files(design: Design) -> dict[str, str]:
    """The text of every file by its name, the same for the same design.

    ``registers/tfra.h`` is C99; its names and addresses are those of every design, and the reset values of the
    constants are those of this one.  ``registers/tfra.html`` is one page that loads nothing, ``registers/tfra.xml`` is
    IP-XACT (IEEE 1685-2014).

    Raises ``InputError`` without the packages of the extra ``ip``.
    """
    require(SOURCE, "ip", "systemrdl-compiler", "peakrdl-cheader", "peakrdl-ipxact")
    top = compiled(parameters(design))
    with scratch(temporary()) as folder, writing(folder.parent):
        _header(top, folder / "tfra.h")
        _ipxact(top, folder / "tfra.xml")
        texts = {f"registers/{name}": (folder / name).read_text(encoding="utf-8") for name in ("tfra.h", "tfra.xml")}
    return {**texts, "registers/tfra.html": register_page(top.get_property("name"), as_map(top))}


def _header(top: AddrmapNode, path: Path) -> None:
    """Names with the hierarchy, not with the parameters' values, which those of shared types have."""
    from peakrdl_cheader.c_standards import CStandard
    from peakrdl_cheader.exporter import CHeaderExporter

    CHeaderExporter().export(top, str(path), std=CStandard.gnu99, reuse_typedefs=False)


def _ipxact(top: AddrmapNode, path: Path) -> None:
    """Its version is that of the register map."""
    from peakrdl_ipxact import IPXACTExporter, Standard

    version = str(as_map(top)["VERSION"].fields[-1].reset)
    exporter = IPXACTExporter(vendor=VENDOR, library=VENDOR, version=version, standard=Standard.IEEE_1685_2014)
    exporter.export(top, str(path), component_name="tfra")
