"""Summary of the contacts on a skin, for the terminal and for JSON."""

from dataclasses import dataclass

import numpy as np

from tfra.model.skin.finding import Mark
from tfra.model.skin.result import SkinResult
from tfra.model.tfra import Status
from tfra.recordings.facts import MEANINGS, Spread, has, span, status_label

MARKS = {
    Mark.EDGE: "the window reaches beyond the array",
    Mark.LARGE: "the region reaches beyond the window, so the force is that of a part",
    Mark.TOUCHING: "the region borders on that of a stronger contact, and both may be one",
}
"""Meaning of each mark, for readers."""


@dataclass(frozen=True)
class SkinFacts:
    """The contacts of a recording in a few numbers; spreads are over all contacts."""

    frames: int
    frames_without_contact: int
    contacts: int
    most_in_a_frame: int
    dropped: int
    """Peaks beyond as many contacts as a frame may have."""
    statuses: dict[str, int]
    """Contacts with each mark and status bit, without those that none has."""
    mu: Spread | None
    force_n: Spread | None
    uncertainty_percent: Spread | None
    """The uncertainty of the learned estimator over |F_z|; no error bar."""
    threshold_percent: float | None
    """Contacts with more uncertainty are implausible."""


def skin_facts(result: SkinResult) -> SkinFacts:
    """The summary of ``result``."""
    windows, unsure = result.windows, result.windows.uncertainty_share
    counts = {flag.name: int(has(windows.status, flag).sum()) for flag in (*Mark, *Status) if flag.name}
    return SkinFacts(
        frames=len(result.found),
        frames_without_contact=int((result.found == 0).sum()),
        contacts=len(result.frame),
        most_in_a_frame=int(result.found.max()),
        dropped=int(result.dropped.sum()),
        statuses={name: count for name, count in counts.items() if count},
        mu=Spread.of(windows.mu),
        force_n=Spread.of(np.linalg.norm(windows.resultant, axis=1)),
        uncertainty_percent=None if unsure is None else Spread.of(100.0 * unsure[~np.isnan(unsure)]),
        threshold_percent=None if windows.threshold is None else 100.0 * windows.threshold,
    )


def skin_lines(facts: SkinFacts) -> list[str]:
    """The same for readers: one status or range a line."""
    dropped = f"; {facts.dropped} more are dropped" if facts.dropped else ""
    flags = {flag.name: (flag, meaning) for flag, meaning in (MARKS | MEANINGS).items()}
    noted = ((count, *flags[name]) for name, count in facts.statuses.items())
    unsure = []
    if (over := facts.threshold_percent) is not None:
        line = span("uncertainty", facts.uncertainty_percent, ".3g", "% of |F_z|", "contacts")
        unsure = [f"{line}; implausible over {over:.3g} %, no error bar"]
    return [
        f"{facts.contacts} contacts in {facts.frames} frames, at most {facts.most_in_a_frame} in one{dropped}",
        *([f"{facts.frames_without_contact} frames: no contact"] if facts.frames_without_contact else []),
        *(f"{count} of all contacts: {status_label(flag)} ({meaning})" for count, flag, meaning in noted),
        span("mu", facts.mu, ".3f", "", "contacts"),
        span("|F|", facts.force_n, ".3g", "N", "contacts"),
        *unsure,
    ]
