"""Errors of sparse operators: the filters of SpTFRA on the paper's contacts and on random ones.

``python -m bench.large.sparse [--contacts N]`` filters the operators of both example sensors at many strengths, writes
``bench/results/sparse.json``, ``bench/results/sparse.png`` and the table in docs/studies/sparse.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bench.publish import ROOT, publish
from tfra.codegen.config.read import load
from tfra.model.arrays import Floats
from tfra.model.boussinesq import Operators, operators
from tfra.model.choices import Adc
from tfra.model.converter import quantise
from tfra.model.cover.contact import Contact
from tfra.model.cover.layer import frames
from tfra.model.cover.scenes import random_contacts
from tfra.model.fixed.butterfly import HADAMARD, taxel_index
from tfra.model.fixed.design import Design
from tfra.model.fixed.tfra.pipeline import FixedTfra
from tfra.model.fixed.words import decode
from tfra.model.metrics import error_force, error_mu, error_phi
from tfra.model.sparse import Filter, filtered, multiplications
from tfra.model.tfra import Result, Tfra

EXAMPLES = {
    "hertz_40x20": "10×10, 4×2 mm, Hertz ellipse 16×8 mm",
    "rectangle_40x40": "10×10, 4×4 mm, rectangle 6×4 mm",
}
SHARES = (1, 2, 3, 5, 7, 9, 11, 13, 17, 21, 25, 31, 41, 51, 61, 71, 81, 91, 100)
THRESHOLDS = (0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50, 100)
STRENGTHS = {"F1": SHARES, "F2": THRESHOLDS, "F3": THRESHOLDS}
SHOWN = {"F1": (81, 51, 25, 13), "F2": (0, 0.1, 1, 3, 5, 10, 20)}
PUBLISHED = {
    "doi": "10.3390/s24237829",
    "seconds_per_frame": 58.68e-3,
    "normal_force_error_percent": 12.6,
    "tangential_force_error_percent": 7.7,
    "power_w": 0.871,
    "companion_largest_error_percent": 14.7,
}
FIXED_MOST = 30
"""Strength up to which the bit-accurate model is measured."""
SEED = 2024
STYLES: dict[str, dict[str, Any]] = {  # colours of Okabe and Ito
    "F1": {"color": "#D55E00", "marker": "o", "ms": 4, "lw": 1},
    "F2": {"color": "#0072B2", "marker": "s", "ms": 4, "lw": 1},
    "F3": {"color": "black", "marker": "o", "ms": 8, "lw": 0, "mfc": "none", "mew": 0.7},
}


def folded_multiplications(design: Design, ops: Operators) -> int | None:
    """The products left after mirror folding; None if the matrices no longer commute with the mirrors."""
    index, sensor, counts = taxel_index(design), design.sensor, {}
    for name, matrix in (vars(ops) | {"normal": ops.c33 @ ops.pinv3}).items():
        noise = 1e-9 * np.abs(matrix).max()
        grid = np.abs(matrix).reshape(2 * (sensor.rows, sensor.columns))
        if any(np.abs(np.flip(grid, axes) - grid).max() > noise for axes in ((0, 2), (1, 3))):
            return None
        counts[name] = int((np.abs(matrix[index[:, 0]][:, index] @ HADAMARD) > noise).sum())
    counts["normal"] = min(counts["normal"], counts["c33"] + counts["pinv3"])
    return sum(counts.values()) + counts["normal"]


def spread(values: Floats) -> dict[str, float]:
    """Median and 95th percentile."""
    return {"median": percent(np.median(values)), "p95": percent(np.percentile(values, 95))}


def percent(value: float | np.floating[Any]) -> float:
    """Round to four decimals, more than the precision of a filter's error."""
    return round(float(value), 4)


class Study:
    """One sensor's frames of the paper's contact and of random ones, estimated with any operators."""

    def __init__(self, example: str, contacts: int) -> None:
        project = load(ROOT / "examples" / f"{example}.toml")
        self.design = project.design
        self.sensor = self.design.sensor
        self.paper = project.contacts
        self.paper_stress = project.layer.frames(self.sensor, self.paper)
        drawn = random_contacts(self.sensor, contacts, np.random.default_rng(SEED))
        stress = frames(self.sensor, drawn)
        exact = Tfra(self.sensor)(stress)
        swept = np.flatnonzero(exact.status == 0)
        self.random: list[Contact] = [drawn[i] for i in swept]
        self.random_stress = stress[swept]
        self.exact = exact.resultant[swept]

    def fixed(self, chosen: Filter) -> dict[str, Any]:
        """The same of the bit-accurate model with ``chosen`` coefficients left, and its products with a factor.

        The converter has 16 bits and holds the hardest of the contacts.
        """
        peak = max(float(np.abs(s).max()) for s in (self.paper_stress, self.random_stress))
        design = replace(self.design, sparse=chosen, adc=Adc(16, 1.05 * peak))
        model = FixedTfra(design)
        errors = self.errors(lambda stress: decode(design, model(quantise(design, stress)).words))
        return {"multiplications": design.nonzero_products, **errors}

    def errors(self, model: Callable[[Floats], Result]) -> dict[str, Any]:
        """Errors (Eqs. 33-35) in %: largest of the paper's contacts, spread of random ones, and the change of F."""
        found = model(self.paper_stress)
        force = error_force([c.force for c in self.paper], found.resultant)
        paper = {
            "force": percent(force.max()),
            "tangential": percent(force[:, :2].max()),
            "normal": percent(force[:, 2].max()),
            "mu": percent(error_mu([c.mu for c in self.paper], found.mu).max()),
            "phi": percent(error_phi(np.degrees([c.phi for c in self.paper]), found.phi_deg).max()),
        }
        found = model(self.random_stress)
        change = np.linalg.norm(found.resultant - self.exact, axis=1) / np.linalg.norm(self.exact, axis=1)
        random = {
            "force": spread(error_force([c.force for c in self.random], found.resultant).max(axis=1)),
            "mu": spread(error_mu([c.mu for c in self.random], found.mu)),
            "phi": spread(error_phi(np.degrees([c.phi for c in self.random]), found.phi_deg)),
            "change": spread(100 * change),
        }
        return {"paper": paper, "random": random}

    def rows(self) -> Iterator[dict[str, Any]]:
        """One measurement for each filter and strength."""
        full = operators(self.sensor)
        for kind, strengths in STRENGTHS.items():
            for strength in strengths:
                chosen = Filter(kind, strength)
                ops = filtered(full, chosen)
                yield {
                    "kind": kind,
                    "strength": strength,
                    "multiplications": multiplications(ops),
                    "folded": folded_multiplications(self.design, ops),
                    **self.errors(Tfra(self.sensor, ops=ops)),
                    "fixed": self.fixed(chosen) if kind == "F2" and chosen.strength <= FIXED_MOST else None,
                }


def table(results: dict[str, Any]) -> str:
    """Markdown rows of the strengths in ``SHOWN``."""
    lines = [
        "| sensor | filter | products | folded | F, worst (F_x, F_y / F_z) | random: F, median | change (95 %) "
        "| bit-accurate: products, F worst |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, result in results.items():
        for row in result["rows"]:
            if row["strength"] not in SHOWN.get(row["kind"], ()):
                continue
            folded = "–" if row["folded"] is None else f"{row['folded']:,}"
            paper, random, fixed = row["paper"], row["random"], row["fixed"]
            core = f"{fixed['multiplications']:,}, {fixed['paper']['force']:.1f} %" if fixed else "–"
            lines.append(
                f"| {EXAMPLES[name].split(', ')[1]} | {row['kind']}, {row['strength']} % | {row['multiplications']:,} "
                f"| {folded} | {paper['force']:.1f} % ({paper['tangential']:.1f} / {paper['normal']:.1f}) "
                f"| {random['force']['median']:.1f} % "
                f"| {random['change']['median']:.1f} % ({random['change']['p95']:.1f} %) | {core} |"
            )
    return "\n".join(lines)


def curve(axes: Axes, rows: list[dict[str, Any]], group: str, measure: str, part: str | None = None) -> None:
    """Error over multiplications, one line a filter; ``part`` picks median (solid) or p95 (dotted)."""
    for kind, style in STYLES.items():
        own = [row for row in rows if row["kind"] == kind]
        values = [row[group][measure][part] if part else row[group][measure] for row in own]
        line, label = (":", None) if part == "p95" else ("-", kind)
        axes.plot([row["multiplications"] for row in own], values, line, label=label, **style)


def plot(results: dict[str, Any]) -> None:
    """Three measures (rows) of both sensors (columns)."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    figure = Figure(figsize=(10, 11), layout="constrained")
    grid = figure.subplots(3, 2, sharex=True)
    for (name, result), (worst, random, change) in zip(results.items(), grid.T, strict=True):
        rows = result["rows"]
        curve(worst, rows, "paper", "force")
        for key, line in (("normal", "--"), ("tangential", "-.")):
            level = PUBLISHED[f"{key}_force_error_percent"]
            worst.axhline(level, color="black", ls=line, lw=1, label=f"published SpTFRA hardware, {key}: {level} %")
        worst.set(title=EXAMPLES[name], ylim=(0, None), ylabel="largest force error, Eq. 35, 24 directions / %")
        for part in ("median", "p95"):
            curve(random, rows, "random", "force", part)
            curve(change, [r for r in rows if r["random"]["change"]["median"] > 1e-3], "random", "change", part)
        random.set(ylabel=f"force error of {result['contacts']} random contacts, Eq. 35 / %", ylim=(0, None))
        change.set(ylabel="their change of F by the filter / %", yscale="log", xscale="log")
        change.set_xlabel("multiplications in matrix products per frame, unfolded")
        change.yaxis.set_major_formatter("{x:g}")
        for axes in (worst, random, change):
            axes.axvline(result["folded"], color="#CC79A7", lw=1.5, label="all entries, mirror-folded")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    for line, label in (("-", "largest (top) or median"), (":", "95th percentile")):
        handles.append(Line2D([], [], color="grey", ls=line, lw=1))
        labels.append(label)
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    figure.savefig(ROOT / "bench" / "results" / "sparse.png", dpi=110, metadata={"Software": None})


def main() -> None:
    """Measure, print, write the JSON and the plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=1000, help="random contacts per sensor")
    contacts = parser.parse_args().contacts
    results: dict[str, Any] = {}
    for name in EXAMPLES:
        study = Study(name, contacts)
        results[name] = {
            "contacts": len(study.random),
            "folded": folded_multiplications(study.design, operators(study.sensor)),
            "rows": list(study.rows()),
        }
    record = {"seed": SEED, "drawn": contacts, "published": PUBLISHED, "results": results}
    plot(results)
    publish("sparse", record, table(results), "docs/studies/sparse.md")


if __name__ == "__main__":
    main()
