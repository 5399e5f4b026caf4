"""The tables of docs/accuracy.md, from the record of a measurement, and what the learned estimator is to reach."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.accuracy.estimators import LEARNED, MAPPED, TFRA, TWO_VARIABLE
from bench.accuracy.measure import PERCENTILES
from bench.accuracy.scenes import NOISES, QUIET, SCENES
from bench.accuracy.skins import held_out
from tfra.train.heldout import NOISES as LEVELS

COARSE = 1.3
"""Mean pitch over thickness from which the limits of coarse sensors hold."""


@dataclass(frozen=True)
class Target:
    """An error in a scene that is to be at most ``limit``, or ``coarse`` on coarse sensors if that differs."""

    scene: str
    measure: str
    percentile: int
    limit: float
    coarse: float | None = None

    def limit_of(self, coarseness: float) -> float:
        """The limit of a sensor whose mean pitch over thickness is ``coarseness``."""
        return self.limit if self.coarse is None or coarseness < COARSE else self.coarse

    def found(self, sensor: Mapping[str, Any]) -> float:
        """The error in one sensor's record."""
        both = sensor["scenes"][self.scene][LEARNED][self.measure]
        return float(both[PERCENTILES.index(self.percentile)])


TARGETS = (
    Target(QUIET, "mu", 50, 0.02, 0.03),
    Target(QUIET, "mu", 95, 0.09, 0.14),
    Target(QUIET, "phi_deg", 50, 2.0),
    Target(QUIET, "force_percent", 50, 3.5, 5.0),
    Target(QUIET, "force_percent", 95, 11.0, 15.0),
    Target("1 % noise", "mu", 50, 0.07),
    Target("1 % noise, mean of 16 frames", "mu", 50, 0.025),
    *(Target(f"offset of {size} %", "mu", 50, 0.025) for size in ("+0.5", "+1", "−1")),
    Target("gains spread by 10 %", "mu", 50, 0.035),
    Target("a dead taxel", "mu", 50, 0.03),
    Target("cover that goes on", "mu", 50, 0.04),
    *(Target(f"ν = {nu}", "mu", 50, 0.03) for nu in ("0.45", "0.5")),
    *(Target(shape, "mu", 50, 0.03) for shape in ("ring", "flat punch", "partial slip", "tilted ellipse")),
)
"""On random contacts."""

PAPER = 0.03
"""How far the median friction found for the paper's contacts may be from the true one, for each of them."""

AGREEMENT = {"mu": 0.002, "phi_deg": 0.1}
"""99th percentiles of the difference between the fixed and the float estimator."""


def verdict(found: float, limit: float, digits: int) -> str:
    """``found`` with a tick, or with the amount that it is over the ``limit``."""
    over = np.format_float_positional(found - limit, precision=2, fractional=False, trim="-")
    return f"{found:.{digits}f} " + ("✓" if found <= limit else f"(+{over})")


def furthest(found: Mapping[str, float]) -> float:
    """Largest distance of the median found from the true friction, over the contacts of one sensor of the paper."""
    return max(abs(median - float(mu)) for mu, median in found.items())


SYMBOLS = {"mu": "μ", "phi_deg": "φ", "force_percent": "\\|ΔF\\|/\\|F\\|"}
UNITS = {"mu": "", "phi_deg": "°", "force_percent": " %"}
FLOAT = (TFRA, TWO_VARIABLE, MAPPED, LEARNED)
DIGITS = {"mu": 3, "phi_deg": 1, "force_percent": 1}

Record = Mapping[str, Any]


def tables(record: Record) -> dict[str, str]:
    """Markdown by the names of the marks in the page."""
    return {
        "accuracy short": short(record),
        "accuracy sensors": sensors(record),
        "accuracy targets": targets(record),
        "accuracy median": robust(record),
    }


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> str:
    """A table whose first ``words`` columns are words and whose others are numbers."""
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * words + "---:|" * (len(heads) - words)]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)])


def sensors(record: Record) -> str:
    """Rows: sensors, with what their network takes."""
    heads = ["sensor", "taxels", "pitch, mm", "thickness, mm", "mean pitch / thickness", "units", "products"]
    rows = (
        [
            f"`{name}`",
            "×".join(map(str, one["taxels"])),
            "×".join(f"{pitch:g}" for pitch in one["pitch_mm"]),
            f"{one['thickness_mm']:g}",
            f"{one['pitch_over_thickness']:.2f}",
            "/".join(map(str, one["units"])),
            f"{one['products']:,}",
        ]
        for name, one in record["sensors"].items()
    )
    return markdown(heads, rows)


def robust(record: Record) -> str:
    """Rows: scenes of all sensors together; columns: float estimators; cells: medians of their errors."""
    rows = ([scene, *(_cell(record["pooled"][scene][who]) for who in FLOAT)] for scene in SCENES)
    return markdown([", ".join(SYMBOLS.values()), *FLOAT], rows)


def targets(record: Record) -> str:
    """Rows: targets that a sensor misses, and the agreement of fixed and float; columns: sensors."""
    every = record["sensors"]
    errors, agreements = [*_errors(every), *_papers(every)], list(_agreements(every))
    cells = [cell for row in (*errors, *agreements) for cell in row[2:] if cell]
    missed = [row for row in errors if any("(+" in cell for cell in row[2:])]
    met = f"Met: {sum('✓' in cell for cell in cells)} of {len(cells)}."
    return markdown(["target", "at most", *every], [*missed, *agreements], words=2) + f"\n\n{met}"


def _errors(every: Record) -> Iterator[list[str]]:
    for target in TARGETS:
        digits, unit = DIGITS[target.measure], UNITS[target.measure]
        part = "median" if target.percentile == 50 else "95th percentile"
        limits = f"{target.limit:g}{unit}" + ("" if target.coarse is None else f", coarse {target.coarse:g}{unit}")
        cells = (
            verdict(target.found(sensor), target.limit_of(sensor["pitch_over_thickness"]), digits)
            for sensor in every.values()
        )
        yield [f"{target.scene}: {SYMBOLS[target.measure]}, {part}", limits, *cells]


def _papers(every: Record) -> Iterator[list[str]]:
    for noise in NOISES[:2]:
        cells = (verdict(furthest(s["paper"][noise]), PAPER, 3) if s["paper"] else "" for s in every.values())
        yield [f"contacts of the paper, {noise}: median μ", f"{PAPER:g}", *cells]


def _agreements(every: Record) -> Iterator[list[str]]:
    for measure, limit in AGREEMENT.items():
        digits = 4 if measure == "mu" else 3
        cells = (verdict(sensor["fixed"][measure], limit, digits) for sensor in every.values())
        name = f"fixed against float: {SYMBOLS[measure]}, 99th percentile"
        yield [name, f"{limit:g}{UNITS[measure]}", *cells]


def short(record: Record) -> str:
    """Pooled medians of the float estimators, and those of a skin's contacts."""
    noises, found = NOISES[1:], held_out()
    rows = [[who, *(_cell(record["pooled"][noise][who]) for noise in noises)] for who in FLOAT]
    skins = [{measure: [found[f"{measure}_50_at_{level:g}"]] for measure in SYMBOLS} for level in LEVELS[1:]]
    rows.append(["learned, 1 to 8 contacts of a skin", *map(_cell, skins)])
    return markdown(["medians of all sensors", *(f"{noise}: {', '.join(SYMBOLS.values())}" for noise in noises)], rows)


def _cell(row: Mapping[str, Sequence[float]]) -> str:
    """The medians."""
    return ", ".join(f"{row[measure][0]:.{DIGITS[measure]}f}{UNITS[measure]}" for measure in SYMBOLS)
