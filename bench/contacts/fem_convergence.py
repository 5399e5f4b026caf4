"""Finite elements against the Fourier series under the paper's two sensors, mesh by mesh.

``python -m bench.contacts.fem_convergence`` measures each mesh in a process of its own, writes
``bench/results/fem_convergence.json`` and the table in docs/studies/fem.md.  The difference is the largest of b_z over
the taxels, for unit forces along x, y and z, in percent of the largest |b_z| under a unit normal force.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, replace
from typing import Any

import numpy as np

from bench.publish import publish
from tfra.model.cover.contact import Contact, ContactShape
from tfra.model.cover.layer import frames
from tfra.model.sensor import SensorArray

CASES = {
    "hertz 8×4 mm on 40×20×3 mm": (
        SensorArray(10, 10, 4e-3, 2e-3, 3e-3),
        Contact(ContactShape.HERTZ, 18e-3, 9e-3, 8e-3, 4e-3, -1.0, 0.0, 0.0),
    ),
    "uniform 6×4 mm on 40×40×3 mm": (
        SensorArray(10, 10, 4e-3, 4e-3, 3e-3),
        Contact(ContactShape.UNIFORM, 18e-3, 18e-3, 3e-3, 2e-3, -1.0, 0.0, 0.0),
    ),
}
MESHES = ((1e-3, 3, 0.48), (0.7e-3, 4, 0.48), (0.5e-3, 4, 0.48), (0.35e-3, 4, 0.48), (1e-3, 3, 0.499))


def series(case: str, poisson: float) -> Any:
    """Responses ``(3, rows, columns)`` to unit forces by the Fourier series, 1/m^2."""
    sensor, contact = CASES[case]
    along = [contact, replace(contact, mu=1.0), replace(contact, mu=1.0, phi=np.pi / 2)]
    pressed, in_x, in_y = frames(sensor, along, poisson=poisson)
    return np.stack([in_x - pressed, in_y - pressed, -pressed])


def run(case: str, size: float, layers: int, poisson: float) -> dict[str, Any]:
    """Measure one mesh, in this process."""
    from tfra.model.cover.fem import Mesh, response

    sensor, contact = CASES[case]
    mesh = Mesh(size, layers)
    sides = [len(planes) - 1 for planes in mesh.planes(sensor, contact)]
    start = time.perf_counter()
    found = response(sensor, contact, mesh, poisson)
    seconds = time.perf_counter() - start
    expected = series(case, poisson)
    percent = 100 * np.abs(found - expected).max(axis=(1, 2)) / np.abs(expected[2]).max()
    return {
        "case": case,
        "mesh": astuple(mesh),
        "poisson": poisson,
        "elements": sides,
        "unknowns": 3 * int(np.prod([2 * n + 1 for n in sides])),
        "difference_percent": percent.round(4).tolist(),
        "seconds": round(seconds, 1),
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    }


def main() -> None:
    """Measure every mesh, store and print."""
    os.environ |= {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    rows = []
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn, max_tasks_per_child=1) as pool:
        for row in pool.map(run, *zip(*((case, *mesh) for case in CASES for mesh in MESHES), strict=True)):
            rows.append(row)
            print(f"{row['case']}, {row['mesh'][0] * 1e3:g} mm: {row['seconds']} s", file=sys.stderr, flush=True)
    publish("fem_convergence", {"rows": rows}, table(rows), "docs/studies/fem.md")


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: one line for each mesh."""
    lines = [
        "| contact | ν | element | elements | unknowns | F_x | F_y | F_z | seconds | memory |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        cells = [row["case"], row["poisson"], f"{row['mesh'][0] * 1e3:g} mm", "×".join(map(str, row["elements"]))]
        cells += [f"{row['unknowns']:,}", *(f"{p:.2f} %" for p in row["difference_percent"])]
        cells += [row["seconds"], f"{row['peak_mib']} MiB"]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
