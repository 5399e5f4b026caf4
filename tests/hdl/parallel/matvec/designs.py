"""Designs of the tests of the matrix-vector unit."""

from __future__ import annotations

from tfra.model.choices import FORMATS, Adc, Architecture, Formats
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray

SHORT = Formats("short", coefficient=12, operand=27, vector_fraction=0, force_fraction=0)
LONG = Formats("long", coefficient=10, operand=10, vector_fraction=16, force_fraction=0)


def make(
    rows: int, columns: int, lanes: int, formats: Formats = FORMATS["standard"], bits: int = 14, words: int = 4
) -> Design:
    sensor = SensorArray(rows, columns, 4e-3, 2e-3, 3e-3)
    return TfraDesign(sensor, adc=Adc(bits), formats=formats, architecture=Architecture(lanes, words))


def label(design: Design) -> str:
    sensor, architecture = design.sensor, design.architecture
    size = f"{sensor.rows}x{sensor.columns}"
    return f"{size}-{architecture.mac_lanes}-{architecture.vector_words}-{design.formats.name}"
