"""What the learned estimator's uncertainty notices, and what two residuals of the forward model do.

    python -m bench.learned.plausibility CONFIG

CONFIG has the learned estimator.  Its tables go to docs/learned.md.  Contacts are random, with half sizes of 0.3 to 3
pitches and mu from 0 to 1, anywhere on the cover.  Each threshold is exceeded by 2 % of the single contacts with 0.1 %
noise.  The residual is that of the forces at the taxels.  The finer one splits each cell into 3 x 3 and finds the
pressure >= 0 that leaves least, for the mu_x and mu_y of the network; it takes too long for a core, and shows what is
possible.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import nnls

from bench.publish import publish
from tfra.codegen.config.read import load
from tfra.engines import Engine, double
from tfra.model.arrays import Floats
from tfra.model.cover.cells import taxel_forces
from tfra.model.cover.contact import Contacts
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import any_contacts
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Result, Tfra

COUNT, FINE_COUNT, SEED = 1000, 300, 99
FALSE_ALARMS = 0.02
SPLIT = 3
ALARMS = (0.01, 0.02, 0.05, 0.1, 0.2)
QUIET, TWO = "one contact, 0.1 % noise", "two contacts"
JUDGES = ("uncertainty", "residual", "finer residual")
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
    yield TWO, both
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
    """Every scene's errors and figures; thresholds, the curve, and the errors of the field."""
    project = load(config)
    sensor, model, rng = project.design.sensor, double(Engine.FLOAT, project), np.random.default_rng(SEED)
    contacts, rows, judged, field = any_contacts(sensor, COUNT, rng), {}, {}, {}
    limits: dict[str, float] = {}
    for name, scene in scenes(sensor, contacts, rng):
        found = model(scene.stress)
        off = 100 * np.linalg.norm(found.resultant - scene.force, axis=1) / np.linalg.norm(scene.force, axis=1)
        figures = judged[name] = judges(config, sensor, scene.stress, found)
        if name == QUIET:
            limits = {judge: float(np.quantile(each, 1 - FALSE_ALARMS)) for judge, each in figures.items()}
            true = taxel_forces(sensor, contacts)
            others = {"TFRA": Tfra(sensor)(scene.stress).forces, "learned": found.forces}
            field = {label: two(100 * distance(forces, true)) for label, forces in others.items()}
        rows[name] = {"force_percent": two(off), "wide": share(off > WIDE)}
        for judge, each in figures.items():
            flag, far = each > limits[judge], off[: len(each)] > WIDE
            rows[name][judge] = {"percent": two(100 * each), "flagged": share(flag), "if_wide": share(flag[far])}
    return rows, {"thresholds": limits, "curve": curve(judged), "field_percent": field}


def judges(config: str, sensor: SensorArray, stress: Floats, found: Result) -> dict[str, Floats]:
    """The uncertainty over the normal force, the residual and the finer residual of each frame."""
    if found.residual is None or found.uncertainty is None:
        raise ValueError(f"{config}: the learned estimator is needed")
    few = slice(FINE_COUNT)
    fine = fine_residual(sensor, stress[few], found.mu_x[few], found.mu_y[few])
    own = found.uncertainty / np.abs(found.resultant[:, 2])
    return dict(zip(JUDGES, (own, found.residual, fine), strict=True))


def curve(judged: dict[str, dict[str, Floats]]) -> dict[str, dict[str, float]]:
    """Share in percent of the frames with two contacts that each judge flags, by its share of false alarms."""
    return {
        f"{100 * alarms:g}": {
            judge: 100 * float(np.mean(judged[TWO][judge] > np.quantile(single, 1 - alarms)))
            for judge, single in judged[QUIET].items()
        }
        for alarms in ALARMS
    }


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
    heads = " | ".join(f"{judge}, % | flagged" for judge in JUDGES)
    lines = [
        f"| frames | \\|ΔF\\|/\\|F\\|, % | {heads} | if over 20 % off |",
        f"|---|{'---:|' * (2 + 2 * len(JUDGES))}",
    ]
    for name, row in rows.items():
        cells = [name, "{:.1f} / {:.1f}".format(*row["force_percent"])]
        for judge in JUDGES:
            cells += ["{:.1f} / {:.1f}".format(*row[judge]["percent"]), f"{row[judge]['flagged']:.0f} %"]
        wide = [row[judge]["if_wide"] for judge in JUDGES]
        cells.append(", ".join("–" if each is None else f"{each:.0f} %" for each in wide) if row["wide"] else "")
        lines.append(f"| {' | '.join(cells)} |")
    limits = (f"{judge} {100 * limit:.2g} %" for judge, limit in more["thresholds"].items())
    field = ("{} {:.1f} / {:.1f} %".format(label, *value) for label, value in more["field_percent"].items())
    lines += ["", f"Thresholds: {', '.join(limits)}."]
    lines += [f"Error of the forces at the taxels, {QUIET}: {', '.join(field)}.", ""]
    lines += [f"| false alarms | {' | '.join(JUDGES)} |", f"|---:|{'---:|' * len(JUDGES)}"]
    for alarms, found in more["curve"].items():
        lines.append(f"| {alarms} % | {' | '.join(f'{found[judge]:.0f} %' for judge in JUDGES)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    measured, also = measure(sys.argv[1])
    publish("plausibility", {"scenes": measured, **also}, table(measured, also), "docs/learned.md")
