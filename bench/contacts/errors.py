"""Sources of TFRA's error: one influence at a time, on random contacts and on the paper's two.

``python -m bench.contacts.errors [--contacts N]`` writes ``bench/results/errors.json``, the figure beside it, the
tables of friction in docs/studies/errors.md, and what demo, README and docs/measured.md say of TFRA's friction.  Errors
are those of Eqs. 33-35 of doi:10.1016/j.mechatronics.2023.103070.
"""

import argparse
import json
import textwrap
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.contacts.scenes import SEED, STUDIES, Scene, groups
from bench.publish import ROOT, insert, store
from tfra.model import truth
from tfra.model.arrays import Floats
from tfra.model.metrics import error_force, turn_deg
from tfra.model.tfra import Result, Tfra

PAGE = "docs/studies/errors.md"
MEASURES = {"force": "#D55E00", "mu": "#0072B2", "phi": "#009E73"}  # colours of Okabe and Ito
NAMES = {"force": "F", "mu": "μ", "phi": "φ"}
TOLD = ("0.3", "0.5", "0.7")
"""True friction coefficients for which the package has the estimated ones."""


def errors(forces: Floats, found: Result) -> dict[str, Floats]:
    """Eqs. 33-35 in percent, ``(n,)`` each: the worst component of the force, mu, phi."""
    tangential = np.hypot(forces[:, 0], forces[:, 1])
    phi = np.degrees(np.arctan2(forces[:, 1], forces[:, 0]))
    return {
        "force": error_force(forces, found.resultant).max(axis=1),
        "mu": 100.0 * np.abs(tangential / np.abs(forces[:, 2]) - found.mu),
        "phi": turn_deg(phi, found.phi_deg) / 3.6,
    }


def measure(case: Scene) -> dict[str, Any]:
    """Median and 95th percentile of the errors in percent, the median of found over true modulus of the resultant,
    how many frames are flagged, and 5th, 50th and 95th percentile of mu in the others."""
    found = Tfra(case.sensor, case.steps)(case.stress)
    spread = {key: np.percentile(values, (50, 95)).round(3) for key, values in errors(case.forces, found).items()}
    moduli = [np.linalg.norm(forces, axis=1) for forces in (found.resultant, case.forces)]
    swept = found.mu[found.status == 0]
    return {key: {"median": float(a), "p95": float(b)} for key, (a, b) in spread.items()} | {
        "modulus": round(float(np.median(moduli[0] / moduli[1])), 3),
        "flagged": int((found.status != 0).sum()),
        "frames": len(found.mu),
        "mu_found": np.percentile(swept, (5, 50, 95)).round(3).tolist() if len(swept) else None,
    }


def friction_table(results: dict[str, dict[str, Any]]) -> str:
    """Markdown: the friction coefficient that is found in frames without a flag, and the share of the others."""
    lines = ["| true μ |" + "".join(f" {who}: μ found | flagged |" for who in results)]
    lines.append("|---:|" + "---:|---:|" * len(results))
    for setting in next(iter(results.values())):
        cells = []
        for row in (rows[setting] for rows in results.values()):
            found = row["mu_found"]
            cells.append("–" if found is None else "{1:.2f} ({0:.2f} to {2:.2f})".format(*found))
            cells.append(f"{row['flagged'] / row['frames']:.0%}")
        lines.append(f"| {setting} | {' | '.join(cells)} |")
    return "\n".join(lines)


def publish_truth(friction: dict[str, Any]) -> None:
    """What package and pages say of TFRA's friction on random contacts, from its results by true friction."""
    found = {mu: friction[mu]["mu_found"][1] for mu in TOLD}
    record = {"source": "bench/results/errors.json", "mu_found": found}
    (ROOT / "model" / "truth.json").write_text(json.dumps(record, indent=1) + "\n")
    truth.medians.cache_clear()
    insert("right", truth_table(friction))
    insert("truth", textwrap.fill(f"- {truth.sentence()}", 120, subsequent_indent="  "), "README.md")


def truth_table(friction: dict[str, Any]) -> str:
    """Markdown with a column for each true friction: the estimate, its error, and frames without one."""
    flagged = (f"{row['flagged'] / row['frames']:.0%}" for row in friction.values())
    percentiles = (row["mu_found"] for row in friction.values())
    found = ("–" if each is None else "{1:.2f} ({0:.2f}–{2:.2f})".format(*each) for each in percentiles)
    lines = {
        "true μ": friction,
        "μ found, median (5–95 %)": found,
        "φ off, median, in degrees": map(_phi, friction.values()),
        "force found over true modulus, median": (f"{row['modulus']:.2f}" for row in friction.values()),
        "frames with a status bit, nearly all `COMPRESSION_ONLY`": flagged,
    }
    head, *rest = (f"| {name} | {' | '.join(cells)} |" for name, cells in lines.items())
    return "\n".join([head, "|---|" + "---:|" * len(friction), *rest])


def _phi(row: dict[str, Any]) -> str:
    """Degrees of a percentage of a full turn; none where most frames are flagged, since these have no direction."""
    return "–" if 2 * row["flagged"] > row["frames"] else f"{3.6 * row['phi']['median']:.0f}"


SHOWN = (0.3, 100.0)
"""Errors from, to, in percent."""


def plot(results: dict[str, dict[str, Any]]) -> None:
    """Write ``bench/results/errors.svg``: a panel each study, of the random contacts."""
    mpl.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "tfra"})
    figure = Figure(figsize=(15, 10), layout="constrained")
    *panels, corner = figure.subplots(3, 4, sharey=True).flat
    for axes, (name, result) in zip(panels, results.items(), strict=True):
        rows = result["random"]
        for (key, color), marker in zip(MEASURES.items(), "os^", strict=True):
            for part, line, text in (("median", "-", ", median"), ("p95", ":", ", 95th percentile")):
                values = [row[key][part] for row in rows.values()]
                axes.plot(list(rows), values, line + marker, color=color, ms=4, label=NAMES[key] + text)
                _mark_outside(axes, values, color)
        axes.set(xlabel=STUDIES[name][0], yscale="log", ylim=SHOWN)
        axes.yaxis.set_major_formatter("{x:g}")
        axes.tick_params(labelleft=True)
        if name == "kernel":
            axes.set_xticks(range(len(rows)), [text.replace(" ", "\n") for text in rows], fontsize=8)
    figure.supylabel("error of random contacts (Eqs. 33–35) / %", fontsize=10)
    corner.set_axis_off()
    corner.legend(*axes.get_legend_handles_labels(), loc="center", fontsize=10)
    figure.savefig(ROOT / "bench" / "results" / "errors.svg", metadata={"Date": None})


def _mark_outside(axes: Axes, values: Sequence[float], color: str) -> None:
    """An arrow at the edge and the value, for each that lies above what is shown."""
    for place, value in enumerate(values):
        if value > SHOWN[1]:
            axes.annotate(
                f"{value:.0f} %", (place, SHOWN[1]), xytext=(8, -24), textcoords="offset points", color=color,
                arrowprops={"arrowstyle": "->", "color": color}, annotation_clip=False,
            )  # fmt: skip


def main() -> None:
    """Measure, write the JSON, the figure and the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contacts", type=int, default=1000, help="random contacts to draw")
    count = parser.parse_args().contacts
    everyone = groups(count)
    results = {
        name: {who: {label: measure(case) for label, case in scenes(group)} for who, group in everyone.items()}
        for name, (_, scenes) in STUDIES.items()
    }
    store("errors", {"drawn": count, "contacts": len(everyone["random"].contacts), "seed": SEED, "results": results})
    for name in ("friction", "half-space"):
        insert(f"{name} found", friction_table(results[name]), PAGE)
    publish_truth(results["friction"]["random"])
    plot(results)


if __name__ == "__main__":
    main()
