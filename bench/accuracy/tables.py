"""The tables of docs/accuracy.md, from the record of a measurement."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from bench.accuracy.estimators import LEARNED, MAPPED, NAMES, TFRA, TWO_VARIABLE
from bench.accuracy.measure import FRACTIONS, FRICTIONS
from bench.accuracy.scenes import NOISES, SCENES
from bench.accuracy.targets import AGREEMENT, PAPER, TARGETS, furthest, verdict

SYMBOLS = {"mu": "μ", "phi_deg": "φ", "force_percent": "\\|ΔF\\|/\\|F\\|"}
UNITS = {"mu": "", "phi_deg": "°", "force_percent": " %"}
DIGITS = {"mu": 3, "phi_deg": 1, "force_percent": 1}

Record = Mapping[str, Any]


def tables(record: Record) -> dict[str, str]:
    """Markdown by the names of the marks in the page."""
    found = {
        "accuracy short": short(record),
        "accuracy sensors": sensors(record),
        "accuracy targets": targets(record),
        "accuracy paper": paper(record),
    }
    for measure in SYMBOLS:
        found[f"accuracy {measure}"] = noises(record, measure)
        found[f"accuracy robust {measure}"] = robust(record, measure)
    return found | {"accuracy fixed": fixed(record)}


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


def noises(record: Record, measure: str) -> str:
    """Rows: sensors and noises; columns: estimators."""
    heads = ["sensor", heading(measure), *NAMES]
    single = {name: sensor["scenes"] for name, sensor in record["sensors"].items()}
    rows = [
        [name, noise, *_cells(scenes[noise], measure)]
        for name, scenes in (single | {"**all**": record["pooled"]}).items()
        for noise in NOISES
    ]
    return markdown(heads, rows, words=2)


def robust(record: Record, measure: str) -> str:
    """Rows: scenes of all sensors; columns: estimators."""
    rows = ([scene, *_cells(record["pooled"][scene], measure)] for scene in SCENES)
    return markdown([heading(measure), *NAMES], rows)


def heading(measure: str) -> str:
    """Of the column whose rows have errors of ``measure``."""
    unit = UNITS[measure].strip()
    return f"error of {SYMBOLS[measure]}" + (f", {unit}" if unit else "")


def _cells(row: Mapping[str, Mapping[str, Sequence[float]]], measure: str) -> list[str]:
    return [both(row[who][measure], DIGITS[measure]) for who in NAMES]


def both(values: Sequence[float], digits: int) -> str:
    """Median and 95th percentile."""
    return " / ".join(f"{value:.{digits}f}" for value in values)


def paper(record: Record) -> str:
    """Rows: true friction of the paper's contacts; columns: sensors and estimators."""
    pressed = {name: sensor["paper"] for name, sensor in record["sensors"].items() if sensor["paper"]}
    rows = [
        [name, noise, who, *(f"{by_mu[f'{mu:g}'][who]:.2f}" for mu in FRICTIONS)]
        for name, by_noise in pressed.items()
        for noise, by_mu in by_noise.items()
        for who in NAMES
    ]
    return markdown(["contacts", "noise", "true μ", *(f"{mu:g}" for mu in FRICTIONS)], rows, words=3)


def targets(record: Record) -> str:
    """Rows: targets; columns: sensors."""
    every = record["sensors"]
    rows = [*_errors(every), *_papers(every), *_agreements(every)]
    cells = [cell for row in rows for cell in row[2:] if cell]
    met = f"Met: {sum('✓' in cell for cell in cells)} of {len(cells)}."
    return markdown(["target", "at most", *every], rows, words=2) + f"\n\n{met}"


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
        digits, bits = 4 if measure == "mu" else 3, str(FRACTIONS[0])
        cells = (verdict(sensor["fixed"][bits][measure], limit, digits) for sensor in every.values())
        name = f"fixed against float: {SYMBOLS[measure]}, 99th percentile"
        yield [name, f"{limit:g}{UNITS[measure]}", *cells]


def fixed(record: Record) -> str:
    """Rows: sensors and fraction bits; columns: differences of fixed and float."""
    heads = ["99th percentile of the difference", "fraction bits", "μ", "φ where μ > 0.05, °", "φ of all frames, °"]
    rows = [
        [name, bits, f"{found['mu']:.5f}", f"{found['phi_deg']:.3f}", f"{found['phi_deg_of_all']:.3f}"]
        for name, sensor in record["sensors"].items()
        for bits, found in sensor["fixed"].items()
    ]
    return markdown(heads, rows)


def short(record: Record) -> str:
    """Pooled errors of the float estimators."""
    shown, measured = (TFRA, TWO_VARIABLE, MAPPED, LEARNED), ", ".join(SYMBOLS.values())
    rows = (
        [who, *(", ".join(_cell(record["pooled"][noise][who], measure) for measure in SYMBOLS) for noise in NOISES[1:])]
        for who in shown
    )
    return markdown(["medians of all sensors", *(f"{noise}: {measured}" for noise in NOISES[1:])], rows)


def _cell(row: Mapping[str, Sequence[float]], measure: str) -> str:
    return f"{row[measure][0]:.{DIGITS[measure]}f}{UNITS[measure]}"
