"""What every study does: frames and tasks in pieces that workers compute, tables, and a page of what is there."""

import resource
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import polars as pl

from tfra.report.html import page, paragraph
from tfra.report.table import Table
from tfra.runtime.digest import digest
from tfra.runtime.store import Store, put
from tfra.study.frames.block import parquet
from tfra.study.frames.frameset import Definition, FrameSet
from tfra.study.tasks import Task
from tfra.study.workers import Workers, fingerprint

PARTIAL = "partial.html"
"""The results so far, in the working folder."""

PAGE_EVERY = 15.0
"""Seconds between two partial pages: one takes a few."""

Reporter = Callable[[str, str, int, int], AbstractContextManager[Callable[[], None]]]
"""Function of a task's name and unit, the number of its jobs, and of those finished; returns the callback for each
finished job."""


class Studied(Protocol):
    """A STUDY file that has been read."""

    @property
    def path(self) -> Path:
        """The file."""

    @property
    def definition(self) -> Definition:
        """Of its frames."""

    @property
    def inputs(self) -> list[Path]:
        """Files that the study reads."""


@dataclass
class Running:
    """Results of a study so far: ``tables`` by name, and the ``times`` of tasks.

    Frames and finished pieces are stored in ``folder`` at once.
    """

    study: Studied
    folder: Path
    workers: Workers
    reporter: Reporter
    tables: dict[str, pl.DataFrame] = field(default_factory=dict)
    times: list[tuple[str, str, int, float, float | None]] = field(default_factory=list)
    last_page: float = field(default_factory=time.perf_counter)

    def run_tasks(self) -> None:
        """Run all tasks of the file."""
        raise NotImplementedError

    def answer(self) -> list[str]:
        """Lines of words."""
        raise NotImplementedError

    def write(self, out: Path) -> None:
        """Write the page and the tables into the folder ``out``."""
        (out / "tables").mkdir()
        for name, table in self.tables.items():
            (out / "tables" / f"{name}.parquet").write_bytes(parquet(table))
        (out / "index.html").write_text(self._page(), encoding="utf-8")

    def _page(self, pending: Sequence[str] = ()) -> str:
        """The page of the tables so far; ``pending`` are the names of those to come."""
        raise NotImplementedError

    def _table_names(self) -> list[str]:
        """Names of the tables that the study makes, in order."""
        raise NotImplementedError

    def _make_frames(self) -> FrameSet:
        definition = self.study.definition
        frames = FrameSet.create(self.folder / f"frames-{definition.hash[:16]}", definition)
        missing, count = frames.missing(), len(definition.all_blocks())
        with self._progress("frames", "blocks", count, count - len(missing)) as advance:
            for _ in self.workers(frames.write, missing):
                advance()
        return frames

    def _run_task(self, task: Task) -> None:
        """Run the missing jobs of a task, and add its tables."""
        key = digest(fingerprint(), repr(task))
        pieces, jobs = Store(self.folder / "pieces" / f"{task.name}-{key}", key), task.jobs
        pieces.create()
        finished = pieces.names()
        missing = [number for number in range(len(jobs)) if _piece_name(number) not in finished]
        with (
            self._as_input_error(),
            self._progress(task.name, task.unit, len(jobs), len(jobs) - len(missing)) as advance,
        ):
            for position, data in self.workers(task, [jobs[number] for number in missing]):
                pieces.put(_piece_name(missing[position]), data)
                advance()
            tables = task.tables(lambda number: pieces.get(_piece_name(number)))
        self._add(tables)

    def _add(self, tables: Mapping[str, pl.DataFrame]) -> None:
        """Add tables, and write the page of all tables so far."""
        self.tables |= tables
        pending = [name for name in self._table_names() if name not in self.tables]
        if pending and time.perf_counter() - self.last_page > PAGE_EVERY:
            put(self.folder, PARTIAL, self._page(pending).encode())
            self.last_page = time.perf_counter()

    @contextmanager
    def _as_input_error(self) -> Iterator[None]:
        """Turn errors of the input that are noticed late into ``InputError``."""
        yield

    @contextmanager
    def _progress(self, name: str, unit: str, jobs: int, finished: int) -> Iterator[Callable[[], None]]:
        """Report a task, and measure its time; yields the callback for each finished job."""
        start = time.perf_counter()
        unit = unit.removesuffix("s") if jobs == 1 else unit
        with self.reporter(name, unit, jobs, finished) as advance:
            yield advance
        seconds, done = time.perf_counter() - start, jobs - finished
        rate = round(done / seconds, 2) if done else None
        self.times.append((name, f"{jobs:,} {unit}", finished, round(seconds, 1), rate))


def times_page(times: Sequence[tuple[str, str, int, float, float | None]], workers: str) -> str:
    """How long the tasks took, on a page of its own, because the rest of a report is the same in every run."""
    header = ("task", "jobs", "finished before", "time / s", "jobs a second")
    kilobytes = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    total = sum(seconds for *_, seconds, _ in times)
    words = f"Done by {workers}: {total:,.1f} s in all. Memory of the largest process: {kilobytes / 1024:,.0f} MB."
    return page("Times of the study", [paragraph(words), Table("Times", header, times).html()], [])


def _piece_name(number: int) -> str:
    return f"{number:06d}"
