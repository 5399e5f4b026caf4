"""Packages of small cores, made once."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from tests.codegen.test_generate import few_frames
from tfra.codegen.generate import generate
from tfra.codegen.package.contents import Part
from tfra.families import find
from tfra.model.choices import SERIAL, Adc, Architecture, Bus, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

PART = Part(find("ecp5-25"), {"LUT": (9000, 24288), "DSP": (9, 28)}, "a LUT is a LUT4 of ECP5")
ICE40 = Part(find("ice40up5k"), {"LUT": (4500, 5280)}, "a LUT is a logic cell of iCE40")

SENSOR = SensorArray(2, 2, 4e-3, 4e-3, 3e-3)
SERIAL_CORE = TfraDesign(SENSOR, "tiny", search=Search(3), architecture=SERIAL)
PARALLEL = TfraDesign(SENSOR, "lanes", search=Search(7), architecture=Architecture(4, 1))
SHORT = Formats("short", coefficient=10, operand=10, vector_fraction=0, force_fraction=0)
"""Few gates, which are placed soon."""
DESIGNS = {
    "serial": (SERIAL_CORE, PART),
    "parallel": (replace(PARALLEL, bus=Bus(2)), PART),
    "ecp5": (replace(PARALLEL, name="cells", target="ecp5"), PART),
    "ice40": (replace(SERIAL_CORE, name="sparse", target="ice40"), ICE40),
    "few": (replace(SERIAL_CORE, name="few", target="ecp5", adc=Adc(8), search=Search(2), formats=SHORT), PART),
    "files": (replace(PARALLEL, name="images", images="readmemh", bus=Bus(4)), PART),
}


def write(folder: Path, texts: Mapping[str, str]) -> None:
    """Files in ``folder`` by their names there."""
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def made(name: str, folder: Path) -> tuple[Design, Path]:
    """A design, and its package in ``folder``."""
    design, part = DESIGNS[name]
    with few_frames():
        generate(design, folder / "package", (), part)
    return design, folder / "package"
