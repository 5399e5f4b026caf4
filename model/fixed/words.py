"""The result stream: one frame is a header, three planes of forces and the status, one word per transfer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tfra.model.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.fixed.scalars import scalar_fraction
from tfra.model.fixed.widths import widths
from tfra.model.tfra import Result, check_frames

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


def layout(design: Design) -> tuple[Field, ...]:
    """Fields of a result frame in order.

    Forces and resultants are worth ``lsb * 2^-exponent``; planes are f_x, f_y, f_z, each row-major.
    """
    operand, m, out = design.formats.operand, design.sensor.taxels, widths(design).output
    fraction, grid = scalar_fraction(design), design.formats.force_fraction
    force = design.adc.lsb * design.sensor.taxel_area
    rows = [
        ("frame", 1, COUNTER_BITS, False, 0, 1.0, "1"),
        ("exponent", 1, design.adc.bits.bit_length(), False, 0, 1.0, "1"),
        ("sweep_index", 1, design.search.steps.bit_length(), False, 0, 1.0, "1"),
        ("phi", 1, operand, False, operand, 360.0, "deg"),
        ("mu", 1, operand, True, fraction, 1.0, "1"),
        ("mu_x", 1, operand, True, fraction, 1.0, "1"),
        ("mu_y", 1, operand, True, fraction, 1.0, "1"),
        ("resultant", 3, out, True, grid, force, "N"),
        ("forces", 3 * m, out, True, grid, force, "N"),
        ("status", 1, STATUS_BITS, False, 0, 1.0, "1"),
    ]
    fields, start = [], 0
    for name, count, bits, signed, point, scale, unit in rows:
        fields.append(Field(name, start, count, bits, signed, point, scale, unit))
        start += count
    return tuple(fields)


def frame_words(design: Design) -> int:
    """Words of a result frame."""
    last = layout(design)[-1]
    return last.start + last.count


def word_bits(design: Design) -> int:
    """Bits of a transfer; shorter fields are extended by their sign or by zeros."""
    return max(f.bits + (not f.signed) for f in layout(design))


def quantise(design: Design, frames: npt.ArrayLike) -> Ints:
    """Converter codes ``(n, rows, columns)`` of ``frames`` in Pa, rounded to nearest.

    Raises ``ValueError`` naming the first taxel that is not finite or over full scale.
    """
    stress = check_frames(design.sensor, frames)
    codes = np.rint(stress / design.adc.lsb)
    limit = 1 << (design.adc.bits - 1)
    bad = np.argwhere((codes < -limit) | (codes > limit))
    if len(bad):
        frame, row, column = bad[0]
        raise ValueError(
            f"frames: frame {frame}, row {row}, column {column} is {stress[tuple(bad[0])]:.6g} Pa, "
            f"over the full scale of {design.adc.full_scale:.6g} Pa"
        )
    return np.minimum(codes, limit - 1).astype(np.int64)


def encode(design: Design, values: dict[str, Ints]) -> Ints:
    """Result frames ``(n, frame_words)`` from one array ``(n,)`` or ``(n, count)`` for each field."""
    columns = [values[f.name].reshape(-1, f.count) for f in layout(design)]
    return np.concatenate(columns, axis=1)


def field(design: Design, words: Ints, name: str) -> Ints:
    """Words ``(n, count)`` of one field."""
    where = next(f for f in layout(design) if f.name == name)
    return words[:, where.start : where.start + where.count]


def decode(design: Design, words: Ints) -> Result:
    """Result frames ``(n, frame_words)`` in SI units."""
    raw = {f.name: field(design, words, f.name) for f in layout(design)}
    value = {f.name: np.multiply(raw[f.name], f.lsb, dtype=np.float64) for f in layout(design)}
    scale = 2.0 ** -raw["exponent"]
    forces = (value["forces"] * scale).reshape(len(words), 3, design.sensor.rows, design.sensor.columns)
    return Result(
        forces,
        value["resultant"] * scale,
        value["phi"][:, 0],
        value["mu"][:, 0],
        value["mu_x"][:, 0],
        value["mu_y"][:, 0],
        raw["sweep_index"][:, 0],
        raw["status"][:, 0],
    )
