"""Designs of TFRA for the tests of parallel blocks, and a block with a test bench of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from amaranth.sim import Simulator

from tfra.model.choices import FORMATS, Adc, Architecture, Formats, Search
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray


def make(
    rows: int,
    columns: int,
    formats: str | Formats = "standard",
    *,
    bits: int = 14,
    threshold: int | None = None,
    steps: int = 100,
    tolerance: float = 0.0,
    lanes: int = 4,
    words: int = 4,
    pitches: tuple[float, float] = (4.0, 2.0),
    thickness: float = 3.0,
) -> TfraDesign:
    """A design with these formats, or those of this name; pitches and thickness in mm."""
    return TfraDesign(
        SensorArray(rows, columns, pitches[0] * 1e-3, pitches[1] * 1e-3, thickness * 1e-3),
        adc=Adc(bits, contact_threshold=threshold),
        search=Search(steps, tolerance),
        formats=FORMATS[formats] if isinstance(formats, str) else formats,
        architecture=Architecture(lanes, words),
    )


def label(design: Design) -> str:
    """Size, lanes, words a cycle and formats of a design, for the name of a test."""
    sensor, architecture = design.sensor, design.architecture
    formats = design.formats.name.replace(" ", "-")
    return f"{sensor.rows}x{sensor.columns}-{architecture.mac_lanes}-{architecture.vector_words}-{formats}"


def simulate(dut: Any, bench: Callable[[Any], Any]) -> None:
    """Run ``bench`` beside ``dut`` to its end."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
