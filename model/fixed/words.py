"""Result words from the model's integers, and SI units from result words."""

from __future__ import annotations

import numpy as np

from tfra.model.arrays import Ints
from tfra.model.fixed.design import Design
from tfra.model.tfra import Result


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
