"""From stress to converter codes, and from result words to SI units."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tfra.model.choices import Choices
from tfra.model.fixed.design import Design
from tfra.model.fixed.numbers import Ints
from tfra.model.tfra import Result, check_frames


def quantise(choices: Choices, frames: npt.ArrayLike) -> Ints:
    """Converter codes ``(n, rows, columns)`` of ``frames`` in Pa, rounded to nearest.

    Raises ``ValueError`` naming the first taxel that is not finite or over full scale.
    """
    stress = check_frames(choices.sensor, frames)
    codes = np.rint(stress / choices.adc.lsb)
    limit = 1 << (choices.adc.bits - 1)
    bad = np.argwhere((codes < -limit) | (codes > limit))
    if len(bad):
        frame, row, column = bad[0]
        raise ValueError(
            f"frames: frame {frame}, row {row}, column {column} is {stress[tuple(bad[0])]:.6g} Pa, "
            f"over the full scale of {choices.adc.full_scale:.6g} Pa"
        )
    return np.minimum(codes, limit - 1).astype(np.int64)


def encode(design: Design, values: dict[str, Ints]) -> Ints:
    """Result frames ``(n, frame_words)`` from one array ``(n,)`` or ``(n, count)`` for each field."""
    columns = [values[f.name].reshape(-1, f.count) for f in design.layout]
    return np.concatenate(columns, axis=1)


def field(design: Design, words: Ints, name: str) -> Ints:
    """Words ``(n, count)`` of one field."""
    where = next(f for f in design.layout if f.name == name)
    return words[:, where.start : where.start + where.count]


def decode(design: Design, words: Ints) -> Result:
    """Result frames ``(n, frame_words)`` in SI units."""
    raw = {f.name: field(design, words, f.name) for f in design.layout}
    value = {f.name: np.multiply(raw[f.name], f.lsb, dtype=np.float64) for f in design.layout}
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
