"""What to change of a design whose words could overflow: the nearest values that do."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import replace

from tfra.model.fixed.design import Design

THINNER = tuple(1 - percent / 50 for percent in range(1, 26))
"""Shares of the cover's thickness that are tried: in steps of two per cent, down to half."""


def fits(design: Design) -> bool:
    """Do all words hold what they may have to?"""
    try:
        _ = design.widths
    except ValueError:
        return False
    return True


def advice(design: Design) -> str:
    """Keys of CONFIG with the nearest values that fit, each alone, in words; empty where none of them does."""
    return " or ".join(_changes(design))


def _changes(design: Design) -> Iterator[str]:
    """More bits and a thicker cover never make words shorter, so that few designs have to be tried."""
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
