"""Designs that tests share; sensors are those of :mod:`tfra.model.cover.scenes`."""

from tfra.model.choices import FORMATS, Adc, Architecture, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


def make_design(sensor: SensorArray, formats: str = "standard", steps: int = 100, tolerance: float = 0.0) -> Design:
    """A small architecture around ``sensor``; the model does not depend on it."""
    return TfraDesign(
        sensor,
        adc=Adc(14),
        search=Search(steps, tolerance),
        formats=FORMATS[formats],
        architecture=Architecture(4),
    )
