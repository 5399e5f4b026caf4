"""Precision of the format sets: bit-accurate model against the float model on the same converter codes.

``python -m bench.exactness.formats [--contacts N]`` measures random contacts on the sensors below, writes
``bench/results/formats.json`` and the table in docs/measured.md.  The contacts are random in shape, place, size,
friction, direction and strength; none was used to choose a format.
"""

import argparse
from typing import Any

import numpy as np

from bench.publish import publish
from tfra.model.choices import FORMATS, Architecture
from tfra.model.cover.scenes import SENSORS, contact_codes
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Tfra

SEED = 2024


def measure(sensor: SensorArray, formats: str, contacts: int) -> dict[str, Any]:
    """Agreement of the two models on the swept ones of ``contacts`` random contacts."""
    design = TfraDesign(sensor, formats=FORMATS[formats], architecture=Architecture(4))
    codes = contact_codes(design, contacts, SEED)
    exact = Tfra(sensor)(codes * design.adc.lsb)
    found = decode(design, FixedTfra(design)(codes).words)
    swept = exact.status == 0
    step = np.abs(found.sweep_index - exact.sweep_index)[swept]
    same = swept & (found.sweep_index == exact.sweep_index)
    modulus = np.linalg.norm(exact.resultant, axis=1)[same]
    turn = (found.phi_deg - exact.phi_deg + 180) % 360 - 180
    return {
        "swept": int(swept.sum()),
        "equal": int((step == 0).sum()),
        "one_step": int((step == 1).sum()),
        "more": int((step > 1).sum()),
        "largest_step": int(step.max()),
        "phi_deg": float(np.abs(turn[swept]).max()),
        "force": float((np.abs(found.forces - exact.forces)[same].max(axis=(1, 2, 3)) / modulus).max()),
        "resultant": float((np.abs(found.resultant - exact.resultant)[same].max(axis=1) / modulus).max()),
    }


def table(results: dict[str, dict[str, Any]]) -> str:
    """Markdown: totals of each format set, and its sensors if a winner differs by more than a step."""
    lines = [
        "| formats | sensor | swept contacts | index equal | one step off | further | φ, worst | taxel force, worst |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for formats, rows in results.items():
        total = {key: sum(row[key] for row in rows.values()) for key in ("swept", "equal", "one_step", "more")}
        worst = {key: max(row[key] for row in rows.values()) for key in ("largest_step", "phi_deg", "force")}
        single = rows.items() if total["more"] else ()
        for sensor, row in [*single, ("**all**", total | worst)]:
            further = f"{row['more']}" + (f" (≤ {row['largest_step']})" if row["more"] else "")
            lines.append(
                f"| `{formats}` | {sensor} | {row['swept']} | {row['equal'] / row['swept']:.2%} | {row['one_step']} "
                f"| {further} | {row['phi_deg']:.5f}° | {row['force']:.1e} · \\|F\\| |"
            )
    return "\n".join(lines)


def main() -> None:
    """Measure, write the JSON and the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=4000, help="contacts per sensor")
    contacts = parser.parse_args().contacts
    results = {
        formats: {name: measure(sensor, formats, contacts) for name, sensor in SENSORS.items()} for formats in FORMATS
    }
    publish("formats", {"contacts_per_sensor": contacts, "seed": SEED, "results": results}, table(results))


if __name__ == "__main__":
    main()
