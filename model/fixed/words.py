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
    """Result frames ``(n, frame_words)`` in SI units; forces at the taxels that a core does not send are NaN."""
    raw = {f.name: field(design, words, f.name) for f in design.layout}
    value = {f.name: np.multiply(raw[f.name], f.lsb, dtype=np.float64) for f in design.layout}
    count, scale = len(words), 2.0 ** -raw["exponent"]
    shape = (count, 3, design.sensor.rows, design.sensor.columns)
    return Result(
        forces=(value["forces"] * scale).reshape(shape) if "forces" in value else np.full(shape, np.nan),
        resultant=value["resultant"] * scale,
        phi_deg=value["phi"][:, 0],
        mu=value["mu"][:, 0],
        mu_x=value["mu_x"][:, 0],
        mu_y=value["mu_y"][:, 0],
        sweep_index=raw["sweep_index"][:, 0] if "sweep_index" in raw else np.full(count, -1, dtype=np.int64),
        status=raw["status"][:, 0],
        uncertainty=(value["uncertainty"] * scale)[:, 0] if "uncertainty" in value else None,
        threshold=design.uncertainty_threshold,
    )
