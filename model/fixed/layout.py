"""The result stream: one frame is a header, the forces at the taxels and the status, one word per transfer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tfra.model.choices import Choices
from tfra.model.fixed.scalars import scalar_fraction

COUNTER_BITS = 16
STATUS_BITS = 8


@dataclass(frozen=True, slots=True)
class Field:
    """``count`` words from ``start``: ``bits`` long, ``fraction`` of them fraction, times ``scale`` in ``unit``."""

    name: str
    start: int
    count: int
    bits: int
    signed: bool
    fraction: int
    scale: float
    unit: str

    @property
    def lsb(self) -> float:
        """Value of one LSB, in ``unit``."""
        return self.scale * 2.0**-self.fraction


def make_layout(choices: Choices, out: int, names: Sequence[str]) -> tuple[Field, ...]:
    """Fields ``names`` of a result frame in order; words of forces have ``out`` bits.

    Forces and resultants are worth ``lsb * 2^-exponent``; planes are f_x, f_y, f_z, each row-major.
    """
    scalar, angle, m = choices.formats.bits("scalar"), choices.formats.bits("cordic"), choices.sensor.taxels
    fraction, grid = scalar_fraction(choices), choices.formats.force_fraction
    force = choices.adc.lsb * choices.sensor.taxel_area
    rows = [
        ("frame", 1, COUNTER_BITS, False, 0, 1.0, "1"),
        ("exponent", 1, choices.adc.bits.bit_length(), False, 0, 1.0, "1"),
        ("sweep_index", 1, choices.search.steps.bit_length(), False, 0, 1.0, "1"),
        ("phi", 1, angle, False, angle, 360.0, "deg"),
        ("mu", 1, scalar, True, fraction, 1.0, "1"),
        ("mu_x", 1, scalar, True, fraction, 1.0, "1"),
        ("mu_y", 1, scalar, True, fraction, 1.0, "1"),
        ("resultant", 3, out, True, grid, force, "N"),
        ("uncertainty", 1, out, True, grid, force, "N"),
        ("forces", 3 * m, out, True, grid, force, "N"),
        ("status", 1, STATUS_BITS, False, 0, 1.0, "1"),
    ]
    fields, start = [], 0
    by_name = {row[0]: row for row in rows}
    for name, count, bits, signed, point, scale, unit in (by_name[name] for name in names):
        fields.append(Field(name, start, count, bits, signed, point, scale, unit))
        start += count
    return tuple(fields)
