"""The tables of docs/accuracy.md, from the record of a measurement."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from bench.accuracy.estimators import LEARNED, MAPPED, TFRA, TWO_VARIABLE
from bench.accuracy.scenes import NOISES, SCENES
from bench.accuracy.targets import AGREEMENT, PAPER, TARGETS, furthest, verdict

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
    """Pooled medians of the float estimators."""
    noises = NOISES[1:]
    rows = ([who, *(_cell(record["pooled"][noise][who]) for noise in noises)] for who in FLOAT)
    return markdown(["medians of all sensors", *(f"{noise}: {', '.join(SYMBOLS.values())}" for noise in noises)], rows)


def _cell(row: Mapping[str, Sequence[float]]) -> str:
    """The medians."""
    return ", ".join(f"{row[measure][0]:.{DIGITS[measure]}f}{UNITS[measure]}" for measure in SYMBOLS)
