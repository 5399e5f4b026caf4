"""What to change of a design whose words could overflow: the nearest values that do."""

from __future__ import annotations

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
    formats, sensor = design.formats, design.sensor
    for bits in range(formats.vector_fraction - 1, -1, -1):
        if fits(replace(design, formats=replace(formats, name="custom", vector_fraction=bits))):
            yield f"formats.vector_fraction_bits = {bits}"
            break
    for share in THINNER:
        thickness = float(f"{1000 * share * sensor.thickness:.3g}")
        if fits(replace(design, sensor=replace(sensor, thickness=thickness / 1000))):
            yield f"sensor.thickness_mm = {thickness:g}"
            break
