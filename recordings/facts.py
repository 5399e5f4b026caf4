"""Summary of a recording and its results in a few numbers, for the terminal and for JSON."""

from dataclasses import asdict, dataclass
from enum import IntFlag
from typing import Any

import numpy as np

from tfra.model.arrays import Bools, Floats, Ints
from tfra.model.tfra import Result, Status

MEANINGS = {
    Status.NO_CONTACT: "nothing presses, all results are zero",
    Status.COMPRESSION_ONLY: "no taxel is under traction, so no tangential force can be found",
    Status.NO_DIRECTION: "the tangential force has no direction, phi is set to 0",
    Status.VANISHING_DENOMINATOR: "the dependent friction coefficient has a zero denominator and is set to zero",
    Status.DEPENDENT_OUT_OF_RANGE: "the dependent friction coefficient exceeds 1",
    Status.INPUT_SATURATED: "a taxel is at an end of the converter's range",
    Status.OUTPUT_SATURATED: "a result exceeded its word length and was saturated",
    Status.IMPLAUSIBLE: "the estimator is unsure of the resultant, or the resultant pulls",
}
"""Meaning of each status bit, for readers."""

RESULTANT_ALONE = "no forces at the taxels: this core gives the resultant alone"
"""A line about results without forces at the taxels."""

WITHOUT_FORCE = (Status.NO_CONTACT, Status.COMPRESSION_ONLY)
"""Status of frames without a tangential force."""


@dataclass(frozen=True)
class Spread:
    """Median, smallest and largest value of ``frames`` frames."""

    frames: int
    median: float
    min: float
    max: float

    @classmethod
    def of(cls, values: Floats) -> "Spread | None":
        """The spread of ``values (n,)``; None without any."""
        return cls(len(values), *(float(f(values)) for f in (np.median, np.min, np.max))) if len(values) else None

    @classmethod
    def of_angles(cls, degrees: Floats) -> "Spread | None":
        """Along the smallest arc that holds all ``degrees (n,)``; each number in [0, 360)."""
        if not len(degrees):
            return None
        around = np.sort(degrees % 360.0)
        gaps = np.diff(around, append=around[0] + 360.0)
        arc = np.roll(around, -1 - int(gaps.argmax()))
        start = float(arc[0])
        return cls(len(arc), float(start + np.median((arc - start) % 360.0)) % 360.0, start, float(arc[-1]))


@dataclass(frozen=True)
class Facts:
    """A recording and its results in a few numbers; spreads are over the frames that have such a value."""

    frames: int
    contact: int
    """Frames with a contact whose tangential force was estimated."""
    statuses: dict[Status, int]
    """Frames with each status bit; those with others than ``WITHOUT_FORCE`` are among the frames with a contact, or
    saturated."""
    phi_deg: Spread | None
    mu: Spread | None
    force_n: Spread | None
    uncertainty_percent: Spread | None
    """The uncertainty of the learned estimator over |F_z|; no error bar."""
    threshold_percent: float | None
    """Frames with more uncertainty are implausible."""
    resultant_alone: bool
    """There are no forces at the taxels."""
    tension_percent_of_taxels: float
    tension_percent_of_stress: float
    frames_without_tension: int


def facts(frames: Floats, result: Result) -> Facts:
    """Return the summary of ``frames (n, rows, columns)`` in Pa and their results."""
    contact = ~has(result.status, *WITHOUT_FORCE)
    directed = contact & ~has(result.status, Status.NO_DIRECTION)
    force = np.linalg.norm(result.resultant, axis=1)
    unsure = result.uncertainty_share
    tension = frames > 0
    return Facts(
        frames=len(frames),
        contact=int(contact.sum()),
        statuses={flag: int(has(result.status, flag).sum()) for flag in Status},
        phi_deg=Spread.of_angles(result.phi_deg[directed]),
        mu=Spread.of(result.mu[contact]),
        force_n=Spread.of(force[~has(result.status, Status.NO_CONTACT)]),
        uncertainty_percent=None if unsure is None else Spread.of(100.0 * unsure[~np.isnan(unsure)]),
        threshold_percent=None if result.threshold is None else 100.0 * result.threshold,
        resultant_alone=result.resultant_alone,
        tension_percent_of_taxels=100.0 * float(tension.mean()),
        tension_percent_of_stress=100.0 * positive_share(frames),
        frames_without_tension=int((~tension.any(axis=(1, 2))).sum()),
    )


def lines(summary: Facts) -> list[str]:
    """Return ``summary`` for readers: one status, range or share a line."""
    unsure = []
    if (over := summary.threshold_percent) is not None:
        line = span("uncertainty", summary.uncertainty_percent, ".3g", "% of |F_z|")
        unsure = [f"{line}; implausible over {over:.3g} %, no error bar"]
    return [
        f"{summary.contact} of {summary.frames} frames: contact",
        *(
            f"{count}{'' if flag in WITHOUT_FORCE else ' of all'}: {status_label(flag)} ({MEANINGS[flag]})"
            for flag, count in summary.statuses.items()
            if count
        ),
        _around(summary.phi_deg) or span("phi", summary.phi_deg, ".1f", "degrees"),
        span("mu", summary.mu, ".3f", ""),
        span("|F|", summary.force_n, ".3g", "N"),
        *unsure,
        *([RESULTANT_ALONE] if summary.resultant_alone else []),
        f"tension: {summary.tension_percent_of_taxels:.1f} % of the taxels, "
        f"{summary.tension_percent_of_stress:.1f} % of the stress; {summary.frames_without_tension} frames have none",
    ]


def positive_share(frames: Floats) -> float:
    """Share of the positive values in the sum of magnitudes; 0 of nothing."""
    total = float(np.abs(frames).sum())
    return float(frames.sum(where=frames > 0)) / total if total else 0.0


def status_label(flag: IntFlag) -> str:
    """The name of one status bit or mark, in words."""
    return str(flag.name).lower().replace("_", " ")


def span(name: str, spread: Spread | None, digits: str, unit: str, of: str = "frames") -> str:
    """Median and limits of a value ``of`` frames or contacts, in words."""
    if spread is None:
        return f"{name}: in no {of.removesuffix('s')}"
    numbers = "median {:{d}}, {:{d}} to {:{d}}".format(spread.median, spread.min, spread.max, d=digits)
    return f"{name}: {numbers} {unit}".rstrip() + f" ({spread.frames} {of})"


def _around(angles: Spread | None) -> str:
    """Text for directions that do not fit in an arc of five sixths, whose median would be meaningless."""
    if angles is None or (angles.max - angles.min) % 360.0 < 300.0:
        return ""
    return f"phi: all around ({angles.frames} frames)"


def has(status: Ints, *flags: IntFlag) -> Bools:
    """Frames ``(n,)`` that have one of the ``flags``."""
    return np.asarray(status & sum(flags) != 0)


def as_dict(summary: Facts) -> dict[str, Any]:
    """Return ``summary`` as plain JSON types; a spread is None where no frame has such a value."""
    spreads = {key: getattr(summary, key) for key in ("phi_deg", "mu", "force_n", "uncertainty_percent")}
    return {
        "contact": summary.contact,
        "no_contact": summary.statuses[Status.NO_CONTACT],
        "compression_only": summary.statuses[Status.COMPRESSION_ONLY],
        "noted": {flag.name: n for flag, n in summary.statuses.items() if n and flag not in WITHOUT_FORCE},
        "threshold_percent": summary.threshold_percent,
        "resultant_alone": summary.resultant_alone,
        "ranges": {key: spread and asdict(spread) for key, spread in spreads.items()},
        "tension": {
            "percent_of_taxels": summary.tension_percent_of_taxels,
            "percent_of_stress": summary.tension_percent_of_stress,
            "frames_without": summary.frames_without_tension,
        },
    }
