"""Held-out errors of the weights that are kept, as `tfra train` has measured them, and what each threshold flags.

    python -m bench.learned.training

Its table goes to docs/training.md.  Sensors have a CONFIG and a file of weights beside it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.codegen.config.weights import Trained, read_weights
from tfra.model.learned.network import Network
from tfra.model.sensor import SensorArray
from tfra.train.errors import COUNT, NOISES, PERCENTILES, SEED, TABLE, Series

CONFIGS = (
    "examples/hertz_40x20.toml",
    "examples/rectangle_40x40.toml",
    "examples/skin_8x12.toml",
    "bench/accuracy/array_7x12.toml",
    "bench/accuracy/array_12x12.toml",
)

SCALES = {"mu": "{:.3f} / {:.3f}", "phi_deg": "{:.1f} / {:.1f}", "force_percent": "{:.1f} / {:.1f}"}
"""How each error is written, median and 95th percentile."""


def trained(config: str) -> Trained:
    """Return the weights beside CONFIG."""
    file = ROOT / config
    return read_weights(file.with_suffix(".weights.npz"), load(file).design.sensor)


def label(sensor: SensorArray) -> str:
    """Size, pitches and thickness."""
    pitches = f"{1e3 * sensor.pitch_x:g}×{1e3 * sensor.pitch_y:g} mm"
    return f"{sensor.rows}×{sensor.columns}, {pitches}, h {1e3 * sensor.thickness:g} mm"


def figures(found: Trained) -> dict[str, Any]:
    """What the file states, the network's size, and the percentage of single contacts that its threshold flags."""
    network, series = Network(found.sensor, found.weights), Series.of(found.sensor, COUNT, SEED)
    flagged = {}
    for level in NOISES:
        outputs = network(series.read(level))
        flagged[f"{level:g}"] = 100 * float(np.mean(outputs[:, 3] > found.threshold * np.abs(outputs[:, 2])))
    return {
        "sensor": label(found.sensor),
        "counts": found.weights.counts,
        "products": network.products,
        "steps": found.prior["training.steps"],
        "threshold": found.threshold,
        "held_out": dict(found.held_out),
        "flagged_percent": flagged,
    }


def table(record: dict[str, dict[str, Any]]) -> str:
    """Markdown."""
    lines = [
        "| sensor | units, products | noise | μ error | φ error, ° | \\|ΔF\\|/\\|F\\|, % | flagged |",
        "|---|---|---:|---|---|---|---:|",
    ]
    for config, row in record.items():
        name = f"`{Path(config).stem}`: {row['sensor']}"
        size = f"{row['counts'][0]}/{row['counts'][1]}, {row['products']:,}"
        for level in NOISES:
            pairs = ([row["held_out"][f"{key}_{share}_at_{level:g}"] for share in PERCENTILES] for key in TABLE)
            cells = (SCALES[key].format(*pair) for key, pair in zip(TABLE, pairs, strict=True))
            flagged = f"{row['flagged_percent'][f'{level:g}']:.1f} %"
            lines.append(f"| {name} | {size} | {100 * level:g} % | {' | '.join(cells)} | {flagged} |")
            name = size = ""
    return "\n".join(lines)


if __name__ == "__main__":
    measured = {config: figures(trained(config)) for config in CONFIGS}
    publish("training", measured, table(measured), "docs/training.md")
