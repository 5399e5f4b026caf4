"""The result stream: one frame is a header, the forces at the taxels and the status, one word per transfer."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

from tfra.model.choices import Choices
from tfra.model.fixed.widths import scalar_fraction
from tfra.model.rounding import Overflow

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
    overflow: Overflow

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
    known = [  # each from word 0 on
        Field("frame", 0, 1, COUNTER_BITS, False, 0, 1.0, "1", Overflow.WRAP),
        Field("exponent", 0, 1, choices.adc.bits.bit_length(), False, 0, 1.0, "1", Overflow.NEVER),
        Field("sweep_index", 0, 1, choices.search.steps.bit_length(), False, 0, 1.0, "1", Overflow.NEVER),
        Field("phi", 0, 1, angle, False, angle, 360.0, "deg", Overflow.WRAP),
        *(Field(mu, 0, 1, scalar, True, fraction, 1.0, "1", Overflow.SATURATE) for mu in ("mu", "mu_x", "mu_y")),
        Field("resultant", 0, 3, out, True, grid, force, "N", Overflow.SATURATE),
        Field("uncertainty", 0, 1, out, True, grid, force, "N", Overflow.SATURATE),
        Field("forces", 0, 3 * m, out, True, grid, force, "N", Overflow.SATURATE),
        Field("status", 0, 1, STATUS_BITS, False, 0, 1.0, "1", Overflow.NEVER),
    ]
    by_name = {field.name: field for field in known}
    starts = accumulate((by_name[name].count for name in names), initial=0)
    return tuple(replace(by_name[name], start=start) for name, start in zip(names, starts, strict=False))
