"""What the residual of the learned estimator notices, and what one with finer cells would.

    python -m bench.learned.plausibility CONFIG

CONFIG has the learned estimator.  Its table goes to docs/learned.md.  Contacts are random, with half sizes of 0.3 to 3
pitches and mu from 0 to 1, anywhere on the cover.  Each threshold is exceeded by 2 % of the single contacts with 0.1 %
noise.  The finer residual splits each cell into 3 x 3 and finds the pressure >= 0 that leaves least, for the mu_x and
mu_y of the network; it takes too long for a core, and shows what is possible.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import nnls

from bench.publish import publish
from tfra.codegen.config import load
from tfra.engines import Engine, double
from tfra.model.arrays import Floats
from tfra.model.cover.cells import taxel_forces
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra

COUNT, FINE_COUNT, SEED = 1000, 300, 99
FALSE_ALARMS = 0.02
SPLIT = 3
QUIET = "one contact, 0.1 % noise"
WIDE = 20
"""Percent of |F|: a resultant this far off misleads."""


@dataclass(frozen=True)
class Scene:
    """Frames ``(n, rows, columns)`` in Pa and the true resultants ``(n, 3)`` in N."""

    stress: Floats
    force: Floats


def noisy(stress: Floats, share: float, rng: np.random.Generator) -> Floats:
    """``stress`` with noise of ``share`` of each frame's peak."""
    return stress + share * peak(stress) * rng.standard_normal(stress.shape)


def peak(stress: Floats) -> Floats:
    """Largest magnitude of each frame, ``(n, 1, 1)``."""
    return np.asarray(np.abs(stress).max(axis=(1, 2), keepdims=True))


def scenes(sensor: SensorArray, contacts: Contacts, rng: np.random.Generator) -> Iterator[tuple[str, Scene]]:
    """Single contacts, and all that an estimator trained on them does not expect."""
    clean, force, n = frames(sensor, contacts), contacts.force, len(contacts)
    quiet = noisy(clean, 1e-3, rng)
    yield QUIET, Scene(quiet, force)
    yield "one contact, no noise", Scene(clean, force)
    yield "one contact, 1 % noise", Scene(noisy(clean, 1e-2, rng), force)
    other, weight = rng.permutation(n), rng.uniform(0.3, 1.5, (n, 1))
    both = Scene(clean + weight[:, None] * clean[other], force + weight * force[other])
    both = replace(both, stress=noisy(both.stress, 1e-3, rng))
    apart = np.linalg.norm((contacts.center - contacts.center[other]) / (sensor.pitch_x, sensor.pitch_y), axis=1) > 4
    yield "two contacts", both
    yield "two contacts, more than 4 pitches apart", Scene(both.stress[apart], both.force[apart])
    for factor in (0.8, 1.2):
        swollen = frames(replace(sensor, thickness=factor * sensor.thickness), contacts)
        yield f"cover of {factor:g} h", Scene(noisy(swollen, 1e-3, rng), force)
    margin = np.ceil(5 * sensor.thickness / np.array([sensor.pitch_x, sensor.pitch_y])).astype(int)
    wide = replace(sensor, rows=sensor.rows + 2 * margin[1], columns=sensor.columns + 2 * margin[0])
    moved = replace(contacts, center=contacts.center + margin * (sensor.pitch_x, sensor.pitch_y))
    inner = frames(wide, moved)[:, margin[1] : -margin[1], margin[0] : -margin[0]]
    yield "cover that goes on", Scene(noisy(inner, 1e-3, rng), force)
    flat, each = quiet.reshape(n, -1), np.arange(n)
    anywhere, pressed = rng.integers(sensor.taxels, size=n), np.abs(flat).argmax(axis=1)
    for name, taxel, value in (
        ("a taxel dead", anywhere, np.zeros(n)),
        ("the most pressed taxel dead", pressed, np.zeros(n)),
        ("a taxel stuck at the peak", anywhere, -np.abs(flat).max(axis=1)),
    ):
        broken = flat.copy()
        broken[each, taxel] = value
        yield name, Scene(broken.reshape(quiet.shape), force)
    yield "offset of 2 % of the peak", Scene(quiet + 0.02 * peak(quiet), force)
    yield "gains spread by 10 %", Scene(quiet * (1 + 0.1 * rng.standard_normal(quiet.shape[1:])), force)


def fine_influence(sensor: SensorArray, split: int = SPLIT) -> tuple[Floats, Floats, Floats]:
    """Stress at the taxels per newton along x, y, z on each of split x split parts of every cell, ``(m, parts)``."""
    pitch = np.array([sensor.pitch_x, sensor.pitch_y])
    i, j = np.divmod(np.arange(split**2 * sensor.taxels), split * sensor.columns)
    center = ((np.stack([j, i], axis=1) + 0.5) / split - 0.5) * pitch
    shape, half = np.full(len(i), "uniform"), np.broadcast_to(pitch / split / 2, center.shape)
    x, y, z = (
        frames(sensor, Contacts(shape, center, half, np.eye(3)[[axis] * len(i)])).reshape(len(i), -1).T
        for axis in range(3)
    )
    return x, y, z


def fine_residual(sensor: SensorArray, stress: Floats, mu_x: Floats, mu_y: Floats) -> Floats:
    """The finer residual of each frame, ``(n,)``, for its friction ``(n,)``."""
    x, y, z = fine_influence(sensor)
    left = []
    for b, along_x, along_y in zip(stress.reshape(len(stress), -1), mu_x, mu_y, strict=True):
        matrix = (along_x * x + along_y * y - z) * sensor.taxel_area
        left.append(nnls(matrix, b / np.linalg.norm(b), maxiter=30 * matrix.shape[1])[1])
    return np.array(left)


def measure(config: str) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """Every scene's errors and residuals, and the errors of the field."""
    project = load(config)
    sensor, model, rng = project.design.sensor, double(Engine.FLOAT, project), np.random.default_rng(SEED)
    contacts, rows, field = any_contacts(sensor, COUNT, rng), {}, {}
    limits = [np.inf, np.inf]
    for name, scene in scenes(sensor, contacts, rng):
        found = model(scene.stress)
        if found.residual is None:
            raise ValueError(f"{config}: the learned estimator is needed")
        off = 100 * np.linalg.norm(found.resultant - scene.force, axis=1) / np.linalg.norm(scene.force, axis=1)
        coarse = found.residual
        few = slice(FINE_COUNT)
        fine = fine_residual(sensor, scene.stress[few], found.mu_x[few], found.mu_y[few])
        if name == QUIET:
            limits = [float(np.quantile(each, 1 - FALSE_ALARMS)) for each in (coarse, fine)]
            true = taxel_forces(sensor, contacts)
            others = {"TFRA": Tfra(sensor)(scene.stress).forces, "learned": found.forces}
            field = {label: two(100 * distance(forces, true)) for label, forces in others.items()}
        flags = coarse > limits[0], fine > limits[1]
        rows[name] = {"force_percent": two(off), "wide": share(off > WIDE)}
        for key, each, flag in zip(("residual", "fine"), (coarse, fine), flags, strict=True):
            far = off[: len(flag)] > WIDE
            rows[name] |= {key: two(100 * each), f"{key}_flagged": share(flag), f"{key}_wide": share(flag[far])}
    return rows, {"thresholds": limits, "field_percent": field}


def distance(forces: Floats, true: Floats) -> Floats:
    """Norm of the difference of the forces at all taxels over that of the true ones, ``(n,)``."""
    axes = (1, 2, 3)
    return np.asarray(np.sqrt(((forces - true) ** 2).sum(axis=axes) / (true**2).sum(axis=axes)))


def two(values: Floats) -> list[float]:
    """Median and 95th percentile."""
    return [float(np.median(values)), float(np.quantile(values, 0.95))]


def share(flags: Any) -> float | None:
    """Percent of the flags that are set; None of none."""
    return 100 * float(np.mean(flags)) if len(flags) else None


def table(rows: dict[str, dict[str, Any]], more: dict[str, Any]) -> str:
    """Markdown."""
    coarse, fine = more["thresholds"]
    lines = [
        "| frames | \\|ΔF\\|/\\|F\\|, % | residual, % | flagged | finer residual, % | flagged | if over 20 % off |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, row in rows.items():
        force, residual, finer = ("{:.1f} / {:.1f}".format(*row[key]) for key in ("force_percent", "residual", "fine"))
        wide = "" if row["fine_wide"] is None else f"{row['residual_wide']:.0f} %, {row['fine_wide']:.0f} %"
        flagged = f"{row['residual_flagged']:.0f} %", f"{row['fine_flagged']:.0f} %"
        lines.append(f"| {name} | {force} | {residual} | {flagged[0]} | {finer} | {flagged[1]} | {wide} |")
    field = ("{} {:.1f} / {:.1f} %".format(label, *value) for label, value in more["field_percent"].items())
    lines += ["", f"Thresholds: {100 * coarse:.1f} % and {100 * fine:.2f} %."]
    return "\n".join([*lines, f"Error of the forces at the taxels, {QUIET}: {', '.join(field)}."])


if __name__ == "__main__":
    measured, also = measure(sys.argv[1])
    publish("plausibility", {"scenes": measured, **also}, table(measured, also), "docs/learned.md")
