"""Duration of a study, on a separate page, because the rest of a report is the same in every run."""

import resource
from collections.abc import Sequence
from dataclasses import dataclass

from tfra.report.html import page, paragraph
from tfra.report.table import Table


@dataclass(frozen=True)
class Timing:
    """A task of ``jobs``, of which ``finished`` came from an earlier run; the others took ``seconds``."""

    name: str
    unit: str
    jobs: int
    finished: int
    seconds: float


def times_page(timings: Sequence[Timing], workers: str) -> str:
    """The page of all tasks; ``workers`` describes the workers in words."""
    header = ("task", "jobs", "finished before", "time / s", "jobs a second")
    total = sum(timing.seconds for timing in timings)
    kilobytes = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    words = f"Done by {workers}: {total:,.1f} s in all. Memory of the largest process: {kilobytes / 1024:,.0f} MB."
    return page("Times of the study", [paragraph(words), Table("Times", header, list(map(_cells, timings))).html()], [])


def _cells(timing: Timing) -> tuple[object, ...]:
    done = timing.jobs - timing.finished
    rate = f"{done / timing.seconds:,.2f}" if done and timing.seconds > 0 else ""
    return timing.name, f"{timing.jobs:,} {timing.unit}", timing.finished, f"{timing.seconds:,.1f}", rate
