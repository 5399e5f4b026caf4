"""A sensor at rest, and faint contacts: frames that the default contact threshold keeps or rejects.

``python -m bench.exactness.rest`` gives the bit-accurate model Gaussian noise, and contacts in noise, with and without
the threshold; it writes ``bench/results/rest.json`` and the two tables in docs/numerics.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.publish import insert, store
from tfra.model.arrays import Floats
from tfra.model.choices import Adc
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import SENSORS, random_contacts
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.tfra import Result, Status, Tfra

PAGE = "docs/numerics.md"
SENSOR = SENSORS["10×10, 4×2 mm, h 3 mm"]
DESIGN = TfraDesign(SENSOR)
FULL = 1 << (DESIGN.adc.bits - 1)
COUNT = 2000
NOISE = (0.02, 0.05, 0.1, 0.15, 0.2)
"""Rms, in percent of full scale."""
FAINT = ((0.2, 0.0), (0.5, 0.0), (1.0, 0.0), (2.0, 0.0), (5.0, 0.0), (0.5, 0.05), (1.0, 0.05), (2.0, 0.05), (5.0, 0.05))
"""Largest stress of a contact and rms of the noise, in percent of full scale."""


def results(stress: Floats, threshold: int | None) -> Result:
    """Results of the model for ``stress (n, rows, columns)``, in codes that are not yet rounded."""
    design = replace(DESIGN, adc=Adc(DESIGN.adc.bits, contact_threshold=threshold))
    return decode(design, FixedTfra(design)(np.rint(stress).astype(np.int64)).words)


def quiet(found: Result) -> float:
    """Share of frames that are no contact."""
    return float((found.status & Status.NO_CONTACT != 0).mean())


def rest(percent: float) -> dict[str, Any]:
    """Noise alone: shares of frames that are no contact, and mu without the threshold."""
    noise = np.random.default_rng(1).normal(0, percent / 100 * FULL, (COUNT, SENSOR.rows, SENSOR.columns))
    before, after = results(noise, 0), results(noise, None)
    return {"noise": percent, "mu": float(np.median(before.mu)), "before": quiet(before), "after": quiet(after)}


def contacts() -> tuple[Floats, Result]:
    """Stress of random contacts with mu = 0.5, its largest magnitude 1, and float's results of those that are swept."""
    drawn = random_contacts(SENSOR, COUNT, np.random.default_rng(3))
    stress = frames(SENSOR, [replace(contact, mu=0.5) for contact in drawn])
    stress = stress[Tfra(SENSOR)(stress).status == 0]
    stress /= np.abs(stress).max(axis=(1, 2), keepdims=True)
    return stress, Tfra(SENSOR)(stress)


def faint(stress: Floats, exact: Result, peak: float, percent: float) -> dict[str, Any]:
    """Contacts in noise: the share that is kept, and errors of phi and mu without the threshold."""
    noise = np.random.default_rng(5).normal(0, percent / 100 * FULL, stress.shape)
    seen = peak / 100 * FULL * stress + noise
    before = results(seen, 0)
    phi = np.abs((before.phi_deg - exact.phi_deg + 180) % 360 - 180)
    errors = {"phi": float(np.median(phi)), "mu": float(np.median(np.abs(before.mu - exact.mu)))}
    return {"peak": peak, "noise": percent, "kept": 1 - quiet(results(seen, None)), **errors}


def main() -> None:
    """Measure and publish."""
    stress, exact = contacts()
    resting = [rest(percent) for percent in NOISE]
    fainter = [faint(stress, exact, *case) for case in FAINT]
    store("rest", {"frames": COUNT, "contacts": len(stress), "rest": resting, "faint": fainter})
    columns = "noise, % of full scale, rms", "median μ without threshold", "no contact: without", "with"
    rows = [f"{r['noise']:g} | {r['mu']:.2f} | {r['before']:.1%} | {r['after']:.1%}" for r in resting]
    insert("rest", table(columns, rows), PAGE)
    columns = "peak, % of full scale", "noise, rms", "kept", "φ off, median", "μ off, median"
    rows = [f"{r['peak']:g} | {r['noise']:g} | {r['kept']:.1%} | {r['phi']:.1f}° | {r['mu']:.2f}" for r in fainter]
    insert("faint", table(columns, rows), PAGE)


def table(columns: Sequence[str], rows: Sequence[str]) -> str:
    """Markdown."""
    return "\n".join([f"| {' | '.join(columns)} |", "|---:" * len(columns) + "|", *(f"| {row} |" for row in rows)])


if __name__ == "__main__":
    main()
