"""Duration of a study, on a separate page, because the rest of a report is the same in every run."""

from __future__ import annotations

import resource
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from tfra.report.html import document, grid, row


@dataclass(frozen=True)
class Timed:
    """A task of ``jobs``, of which ``kept`` came from an earlier run; the others took ``seconds``."""

    name: str
    unit: str
    jobs: int
    kept: int
    seconds: float


def times(tasks: Sequence[Timed], who: str) -> str:
    """The page of ``tasks``; ``who`` describes the workers."""
    header = ["task", "jobs", "there already", "time / s", "jobs a second"]
    rows = (row(_cells(task), {0}) for task in tasks)
    total = sum(task.seconds for task in tasks)
    words = f"Done by {who}: {total:,.1f} s in all. Memory of the largest process: {_largest_mb():,.0f} MB."
    return document("Times of the study", [f"<p>{escape(words)}</p>", grid("Times", header, [rows], {0})], "")


def _cells(task: Timed) -> list[str]:
    done = task.jobs - task.kept
    rate = f"{done / task.seconds:,.2f}" if done and task.seconds > 0 else ""
    return [task.name, f"{task.jobs:,} {task.unit}", f"{task.kept:,}", f"{task.seconds:,.1f}", rate]


def _largest_mb() -> float:
    """Of this process and those that it has waited for."""
    return max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1024
