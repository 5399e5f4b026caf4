"""Sizes of the paper's contacts, which it does not state, fitted to its published estimates.

``python -m bench.contacts.calibrate`` fits the half sizes of both contacts of doi:10.1016/j.mechatronics.2023.103070 to
its Tables 1 and 2, and writes ``bench/results/calibration.json``, the figure beside it and the tables in
docs/studies/calibration.md.  Fitted are phi, mu and the modulus of the forces in the seven directions from 0 to 90
degrees; by Eqs. 29-31 that modulus is F_sens, so it depends on the frame alone, as phi does.  Lengths here are in mm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.contacts.calibrate_figure import plot
from bench.contacts.fits import CASES, HELD_OUT, Case, best, columns, displaced, fit, residuals
from bench.publish import insert, store

PAGE = "docs/studies/calibration.md"


def fits_table(case: Case, fits: list[dict[str, Any]]) -> str:
    """Markdown: one row a fit, by misfit."""
    lines = [
        "| shape | sampling | centre | half sizes | misfit | nine centres: φ | nine centres: μ |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for chosen in sorted(fits, key=lambda fit: float(fit["misfit"])):
        a, b, x, y = chosen["place"]
        centre = "middle" if chosen["fit"] == "centred" else f"{x:+.2f}, {y:+.2f} mm"
        (phi, mu), (phi_most, mu_most) = (f(displaced(case, chosen), axis=0) for f in (np.min, np.max))
        lines.append(
            f"| {chosen['shape']} | {chosen['sampling']} | {centre} | {a:.2f} × {b:.2f} mm | {chosen['misfit']:.2f} "
            f"| {phi:.1f}° to {phi_most:.1f}° | {mu:.2f} to {mu_most:.2f} |"
        )
    lines.append("| published | | | | | {}° to {}° | {:.2f} to {:.2f} |".format(*case.nine))
    return "\n".join(lines)


def residual_table(case: Case, fits: list[dict[str, Any]]) -> str:
    """Markdown: published values of each direction beside those of both fits."""
    lines = [
        "| φ_ref | φ: published | centred | free | μ: published | centred | free "
        "| modulus: published | centred | free |",
        "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    phi_ref, published = case.published
    rows = zip(phi_ref, published, *(columns(case, best(fits, name)) for name in ("centred", "free")), strict=True)
    for angle, *values in sorted(rows, key=lambda row: float(row[0])):
        phi, mu, force = zip(*values, strict=True)
        cells = [f"{v:z.2f}°" for v in phi] + [f"{v:.2f}" for v in mu] + [f"{v:.2f} N" for v in force]
        lines.append(f"| {angle:.0f}°{' (not fitted)' if angle == HELD_OUT else ''} | {' | '.join(cells)} |")
    return "\n".join(lines)


def record(case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """The part of a case that the JSON stores."""
    fits, (phi_ref, published) = result["fits"], case.published
    centred = best(fits, "centred")
    chosen = {name: columns(case, best(fits, name)) for name in ("centred", "free")}
    fitted = phi_ref != HELD_OUT
    return {
        "half_x_mm": case.half_x.tolist(),
        "half_y_mm": case.half_y.tolist(),
        "misfit": result["scans"][centred["shape"], centred["sampling"]].round(2).tolist(),
        "near_at_0_deg": result["near"],
        "fits": [fit | {"place": fit["place"].round(3).tolist(), "misfit": round(fit["misfit"], 4)} for fit in fits],
        "phi_ref_deg": phi_ref.tolist(),
        "published": published.round(4).tolist(),
        "estimates": {name: found.round(4).tolist() for name, found in chosen.items()},
        "rms_phi_mu_force": {
            name: np.sqrt((residuals(found, published)[fitted] ** 2).mean(axis=0)).round(3).tolist()
            for name, found in chosen.items()
        },
    }


def main() -> None:
    """Fit both cases, write the JSON, the figure and the tables."""
    results = {name: fit(case) for name, case in CASES.items()}
    store("calibration", {name: record(case, results[name]) for name, case in CASES.items()})
    for name, case in CASES.items():
        insert(f"{name} fits", fits_table(case, results[name]["fits"]), PAGE)
        insert(f"{name} residuals", residual_table(case, results[name]["fits"]), PAGE)
    plot(CASES, results)


if __name__ == "__main__":
    main()
