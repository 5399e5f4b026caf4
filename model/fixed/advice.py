"""Advice for a design whose words could overflow: the nearest values that avoid it."""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import replace

from tfra.model.fixed.design import Design

THINNER = tuple(1 - percent / 50 for percent in range(1, 26))
"""Shares of the cover's thickness to try: in steps of two per cent, down to half."""


def fits(design: Design) -> bool:
    """Whether all words hold their proven range."""
    try:
        _ = design.widths
    except ValueError:
        return False
    return True


def advice(design: Design) -> str:
    """Keys of CONFIG with the nearest value that fits when changed alone, as text; empty where none fits."""
    return " or ".join(_changes(design))


def _changes(design: Design) -> Iterator[str]:
    """More bits and a thicker cover never make words shorter, so few designs have to be tried."""
    formats, sensor = design.formats, design.sensor
    fewer = [replace(formats, name="custom", vector_fraction=bits) for bits in range(formats.vector_fraction)[::-1]]
    first = bisect_left(fewer, True, key=lambda each: fits(replace(design, formats=each)))
    if first < len(fewer):
        yield f"formats.vector_fraction_bits = {fewer[first].vector_fraction}"
    thinner = [float(f"{1000 * share * sensor.thickness:.3g}") for share in THINNER]
    sensors = [replace(sensor, thickness=mm / 1000) for mm in thinner]
    first = bisect_left(sensors, True, key=lambda each: fits(replace(design, sensor=each)))
    if first < len(thinner):
        yield f"sensor.thickness_mm = {thinner[first]:g}"
