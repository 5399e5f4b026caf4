"""Sensors and designs that tests share."""

from __future__ import annotations

from tfra.model.design import FORMATS, Adc, Architecture, Design, Search
from tfra.model.sensor import SensorArray

SENSORS = {
    "10x10, 4x2 mm": SensorArray(10, 10, 4e-3, 2e-3, 3e-3),
    "10x10, 4x4 mm": SensorArray(10, 10, 4e-3, 4e-3, 3e-3),
    "8x8, 2x2 mm": SensorArray(8, 8, 2e-3, 2e-3, 3e-3),
    "5x7, 3x3 mm": SensorArray(5, 7, 3e-3, 3e-3, 2e-3),
    "4x6, 5x3 mm": SensorArray(4, 6, 5e-3, 3e-3, 2e-3),
    "16x16, 1x1 mm": SensorArray(16, 16, 1e-3, 1e-3, 1.5e-3),
}


def make_design(sensor: SensorArray, formats: str = "standard", steps: int = 100, tolerance: float = 0.0) -> Design:
    """A small architecture around ``sensor``; the model does not depend on it."""
    return Design(
        sensor,
        adc=Adc(14),
        search=Search(steps, tolerance),
        formats=FORMATS[formats],
        architecture=Architecture(4, min(26, steps + 1)),
    )
