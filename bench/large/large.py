"""Large arrays without m x m matrices: four ways to multiply, measured against dense float TFRA.

``python -m bench.large.large [--sizes N ...]`` writes ``bench/results/large.json``, ``bench/results/large.png`` and the
tables of docs/studies/large_arrays.md.  Random contacts of up to 6 x 6 taxels, 14-bit frames; products are counted in
the cheapest form each way has (mirror-folded factors, symmetric taps added up first).
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.large.separable import ORDER, Separable, SeparableProducts, separated
from bench.large.toeplitz import IterativeProducts
from bench.publish import ROOT, insert, store
from tfra.model.arrays import Floats
from tfra.model.boussinesq import Operators, operators
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import codes_of, local_contacts
from tfra.model.fixed.tfra.design import TfraDesign
from tfra.model.sensor import SensorArray
from tfra.model.tfra import Dense, Products, Result, Tfra

SEED = 2024
PITCHES = {"4 mm": 4e-3, "2 mm": 2e-3}
THICKNESS = 3e-3
CONTACTS = {10: 400, 16: 400, 32: 200, 64: 60}
"""Sizes and how many contacts each gets."""
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
RADII = (3, 5, 8, 12, 20)
STEPS = (8, 16, 32, 64)
MANY = 64
"""Steps where only the kernels' radius is of interest."""
ITERATED = 60
"""Contacts, the first ones, that iterative ways get."""
SHOWN = {"separable": TOLERANCES[2:], "separable, 18 bits": (1e-5,), "conjugate gradients": (16, 64)}
CUT = (8, 20)
"""Radii in the table, at 32x32."""
MULTIPLIERS, CLOCK, WORDS = 128, 100e6, 1024
"""Of an ECP5-85: multipliers kept busy, clock in Hz, words of 18 bits in a block memory."""
VECTORS, VECTOR_BLOCK = 11, 512
"""b twice, n, g, d0, d1, d2 (then e0, e1, y), p, q and two for forces on their way out; 36-bit words of a block."""
GROUP = 8
"""Columns of an operator that are computed together."""
BUDGETS = (
    ("32×32, 4 mm", 1e-5, 64, 100e6),
    ("32×32, 2 mm", 1e-5, 64, 100e6),
    ("64×64, 4 mm", 1e-5, 150, 125e6),
    ("64×64, 2 mm", 1e-4, 150, 125e6),
    ("64×64, 2 mm", 1e-5, 150, 125e6),
)
"""Cores: array, tolerance, multipliers, clock in Hz."""
STYLES: dict[str, dict[str, Any]] = {  # colours of Okabe and Ito
    "separable": {"color": "#0072B2", "marker": "o"},
    "separable, 18 bits": {"color": "#56B4E9", "marker": "o", "ls": "--"},
    "conjugate gradients": {"color": "#D55E00", "marker": "s"},
    "short kernels": {"color": "#E69F00", "marker": "^"},
    "short inverses": {"color": "#009E73", "marker": "v"},
}


@dataclass(frozen=True)
class Candidate:
    """One way to multiply: its family, its strength, how, real products a frame and coefficient words."""

    family: str
    strength: float
    products: Products
    multiplications: int
    words: int


class Windowed(Dense):
    """The dense operators cut to ``|di|, |dj| <= radius`` around each taxel: a row for every place on the array."""

    def __init__(self, sensor: SensorArray, radius: int) -> None:
        ops = operators(sensor)
        i, j = np.divmod(np.arange(sensor.taxels), sensor.columns)
        near = np.maximum(np.abs(i[:, None] - i), np.abs(j[:, None] - j)) <= radius
        super().__init__(Operators(**{name: matrix * near for name, matrix in vars(ops).items()}))
        self._normal = (ops.c33 @ ops.pinv3) * near
        self.sums = ops.pinv1.sum(axis=0), ops.pinv2.sum(axis=0)


def convolutions(steps: int) -> int:
    """Convolutions of a frame: three of n; steps with C33, with A A^T for e0, e1 and d (six each); C33 C33 y, A^T y."""
    return 3 + steps + 2 * (6 * steps + 2) + 6 * steps + 3


def transforms(sensor: SensorArray, steps: int) -> int:
    """Products of a frame when whole kernels are applied by real Fourier transforms of twice the array's sides.

    A transform of N points takes N log2 N real products, a spectrum 2 N; A A^T is eight transforms and six spectra.
    """
    points = 4 * sensor.taxels
    transform, spectrum = points * math.log2(points), 2 * points
    solve, gram = 2 * transform + spectrum, 8 * transform + 6 * spectrum
    rest = (4 + 2 * 4 + 4) * transform + (3 + 2 * 2 + 3) * spectrum
    return round(steps * (solve + 3 * gram) + rest)


def candidates(sensor: SensorArray, parts: dict[str, Separable]) -> Iterator[Candidate]:
    """All methods that are feasible on ``sensor``."""
    m, longest = sensor.taxels, max(sensor.rows, sensor.columns)
    for tolerance in TOLERANCES:
        cut = {name: part.up_to(tolerance) for name, part in parts.items()}
        for family, bits in (("separable", None), ("separable, 18 bits", 18)):
            products = SeparableProducts(sensor, cut, bits)
            yield Candidate(family, tolerance, products, products.multiplications, products.words)
    for steps in STEPS if longest <= 32 else SHOWN["conjugate gradients"]:
        products = IterativeProducts(sensor, None, steps)
        yield Candidate("conjugate gradients", steps, products, transforms(sensor, steps), 3 * m)
    for radius in RADII if longest <= 32 else ():
        if radius < longest - 1:
            taps = (radius + 1) ** 2
            count = m * taps * convolutions(MANY)
            yield Candidate("short kernels", radius, IterativeProducts(sensor, radius, MANY), count, 3 * taps)
            taps = (2 * radius + 1) ** 2
            distinct = min(radius + 1, (sensor.rows + 1) // 2) * min(radius + 1, (sensor.columns + 1) // 2)
            yield Candidate("short inverses", radius, Windowed(sensor, radius), 9 * m * taps, 8 * distinct * taps)


def agreement(found: Result, exact: Result, part: slice) -> dict[str, Any]:
    """``found`` against the ``part`` of ``exact`` frames that it is of: winners, forces over |F|, mu and phi."""
    swept = exact.status[part] == 0
    step = np.abs(found.sweep_index - exact.sweep_index[part])
    modulus = np.linalg.norm(exact.resultant[part], axis=1)
    force = np.abs(found.forces - exact.forces[part]).max(axis=(1, 2, 3)) / modulus
    same = swept & (step == 0)
    return {
        "swept": int(swept.sum()),
        "equal": float(same.sum() / swept.sum()),
        "one_step": float((step[swept] <= 1).mean()),
        "force": float(np.median(force[swept])),
        "force_worst": float(force[same].max()) if same.any() else None,
        "mu": float(np.abs(found.mu - exact.mu[part])[swept].max()),
        "phi_deg": float(np.abs((found.phi_deg - exact.phi_deg[part] + 180) % 360 - 180)[swept].max()),
    }


def study(sensor: SensorArray, contacts: int) -> dict[str, Any]:
    """All candidates on the same frames."""
    rng, design = np.random.default_rng(SEED), TfraDesign(sensor)
    stress = codes_of(design, frames(sensor, local_contacts(sensor, contacts, rng)), rng) * design.adc.lsb
    exact, parts = Tfra(sensor)(stress), separated(sensor)
    rows = []
    for candidate in candidates(sensor, parts):
        part = slice(ITERATED if isinstance(candidate.products, IterativeProducts) else None)
        rows.append(
            {
                "family": candidate.family,
                "strength": candidate.strength,
                "products": candidate.multiplications,
                "words": candidate.words,
                **agreement(Tfra(sensor, ops=candidate.products)(stress[part]), exact, part),
            }
        )
    terms = {
        f"{tolerance:g}": {name: part.up_to(tolerance).terms for name, part in parts.items()}
        for tolerance in TOLERANCES
    }
    return {"swept": int((exact.status == 0).sum()), "terms": terms, "rows": rows}


def frames_per_second(products: int, multipliers: int = MULTIPLIERS, clock: float = CLOCK) -> float:
    """Frames per second by the multipliers, with 5 % of the time lost."""
    return 0.95 * multipliers * clock / products


def table(results: dict[str, Any]) -> str:
    """Markdown: the separable operators on every sensor, and the other ways where they are shown."""
    lines = [
        "| array, pitch | way | strength | products | coefficient words, blocks | frames/s | index equal (±1) "
        "| taxel force: median, worst | μ, worst |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for sensor, result in results.items():
        for row in result["rows"]:
            shown = SHOWN.get(row["family"], CUT if sensor.startswith("32") else ())
            if row["strength"] in shown:
                worst = "–" if row["force_worst"] is None else f"{row['force_worst']:.1e}"
                lines.append(
                    f"| {sensor} | {row['family']} | {row['strength']:g} | {row['products']:,} "
                    f"| {row['words']:,}, {-(-row['words'] // WORDS)} | {frames_per_second(row['products']):,.0f} "
                    f"| {row['equal']:.1%} ({row['one_step']:.1%}) | {row['force']:.0e}, {worst} | {row['mu']:.1e} |"
                )
    return "\n".join(lines)


def term_table(results: dict[str, Any]) -> str:
    """Markdown: terms of each operator by array and tolerance."""
    names = list(next(iter(results.values()))["terms"][f"{TOLERANCES[0]:g}"])
    lines = ["| array, pitch | tolerance | " + " | ".join(f"`{name}`" for name in names) + " |"]
    lines.append("|---|---:|" + "---:|" * len(names))
    for sensor, result in results.items():
        for tolerance, terms in list(result["terms"].items())[2:]:
            lines.append(f"| {sensor} | {tolerance} | " + " | ".join(str(terms[name]) for name in names) + " |")
    return "\n".join(lines)


def budget_table(results: dict[str, Any]) -> str:
    """Markdown: block memories and frames per second of the cores in ``BUDGETS`` that were measured."""
    lines = [
        "| array, pitch | tolerance | terms applied | products | multipliers, clock | cycles of products | frames/s "
        "| blocks: coefficients + vectors + Z twice |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for sensor, tolerance, multipliers, clock in BUDGETS:
        if sensor not in results:
            continue
        terms, size = results[sensor]["terms"][f"{tolerance:g}"], int(sensor.split("×")[0])
        row = next(r for r in results[sensor]["rows"] if (r["family"], r["strength"]) == ("separable", tolerance))
        rate = frames_per_second(row["products"], multipliers, clock)
        parts = row["words"], VECTORS * size**2 * WORDS // VECTOR_BLOCK, 2 * GROUP * size * max(terms.values())
        blocks = [-(-words // WORDS) for words in parts]
        lines.append(
            f"| {sensor} | {tolerance:g} | {sum(terms[name] for name in ORDER)} | {row['products']:,} "
            f"| {multipliers}, {clock / 1e6:g} MHz | {clock / rate:,.0f} | {rate:,.0f} "
            f"| {' + '.join(str(n) for n in blocks)} = {sum(blocks)} |"
        )
    return "\n".join(lines)


def panel(axes: Axes, rows: list[dict[str, Any]], values: Floats) -> None:
    """One line a family over products."""
    for family, style in STYLES.items():
        own = [i for i, row in enumerate(rows) if row["family"] == family]
        axes.plot([rows[i]["products"] for i in own], values[own], ms=4, lw=1, label=family, **style)


def plot(results: dict[str, Any], size: int) -> None:
    """Exactness over products at one size, a column for each pitch."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    figure = Figure(figsize=(10, 7), layout="constrained")
    shown = {name: result for name, result in results.items() if name.startswith(f"{size}×")}
    for (name, result), axes in zip(shown.items(), figure.subplots(2, len(shown), sharex=True).T, strict=True):
        rows = result["rows"]
        panel(axes[0], rows, 100 * (1 - np.array([row["equal"] for row in rows])))
        panel(axes[1], rows, np.array([row["force"] for row in rows]))
        axes[0].set(title=f"{name}, h {1e3 * THICKNESS:g} mm", ylabel="frames with another sweep index / %")
        axes[0].set_yscale("symlog", linthresh=1)
        axes[0].set_ylim(-0.1, 110)
        axes[1].set(xlabel="real products a frame", ylabel="median taxel force error / |F|", xscale="log", yscale="log")
        for each in axes:
            each.axvline(MULTIPLIERS * CLOCK / 1000, color="grey", ls=":", label="1,000 frames/s")
            each.axvline(9 * size**4 / 4, color="black", ls=":", label="dense, mirror-folded")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    figure.savefig(ROOT / "bench" / "results" / "large.png", dpi=110, metadata={"Software": None})


def main() -> None:
    """Measure, print, write the JSON, the tables and the plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=list(CONTACTS), choices=list(CONTACTS))
    sizes = parser.parse_args().sizes
    results = {}
    for size in sizes:
        for name, pitch in PITCHES.items():
            sensor = SensorArray(size, size, pitch, pitch, THICKNESS)
            results[f"{size}×{size}, {name}"] = study(sensor, CONTACTS[size])
            operators.cache_clear()  # 1 GB of dense matrices at 64x64
    store("large", {"seed": SEED, "thickness": THICKNESS, "results": results})
    plot(results, 32 if 32 in sizes else max(sizes))
    insert("large", table(results), "docs/studies/large_arrays.md")
    insert("terms", term_table(results), "docs/studies/large_arrays.md")
    insert("budgets", budget_table(results), "docs/studies/large_arrays.md")


if __name__ == "__main__":
    main()
