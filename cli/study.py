"""``tfra study``: quantization error studies."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from tfra.cli.common import Json, OutDirectory, WorkFolder, failures, print_json
from tfra.runtime.errors import InputError, require

Study = Annotated[Path, typer.Argument(metavar="STUDY", help="CONFIG, frames and comparisons, in TOML.")]
WorkersOption = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Number of processes. Default: one for each processor.")
]
Scheduler = Annotated[
    str | None, typer.Option(metavar="tcp://HOST:PORT", help="Use the workers of this Dask scheduler instead.")
]
TrialsOption = Annotated[
    str | None,
    typer.Option(
        "--trials", metavar="URL", help="Database of the trials: postgresql://… to share them, or sqlite:///FILE."
    ),
]

_EXTRAS = ("polars", "optuna", "plotly")


def study(
    study: Study,
    out: OutDirectory,
    work: WorkFolder = None,
    workers: WorkersOption = None,
    scheduler: Scheduler = None,
    trials: TrialsOption = None,
    json: Json = False,
) -> None:
    """Split the error into method, converter and word lengths, and search for word lengths that are enough.

    Of a skin, whose CONFIG has a section window, also contacts that are missed; word lengths are those of the window.

    Writes index.html, tables in Parquet and the designs found. OUT.work/partial.html has the results while it runs.
    """
    require("tfra study", "study", *_EXTRAS, *(["distributed"] if scheduler else []))
    from tfra.study.run import run
    from tfra.study.studyfile import load_study
    from tfra.study.workers import LostWorkerError, SchedulerError, cluster, processes

    if scheduler and workers:
        raise InputError("--workers", "", "is for local processes: a scheduler has its own workers")
    loaded = load_study(study)
    count = workers or len(os.sched_getaffinity(0))
    pool = cluster(scheduler) if scheduler else processes(count)
    who = f"workers of {scheduler}" if scheduler else f"{count} process{'es' if count > 1 else ''}"
    folder = work or Path(f"{os.path.normpath(out)}.work")
    hint = f" Finished work is kept in {folder}: the same command continues it"
    try:
        with failures("study", LostWorkerError, hint=hint):
            summary = run(loaded, out, folder, pool, who, _progress, trials)
    except SchedulerError as error:
        raise InputError("--scheduler", "", str(error)) from None
    if json:
        print_json({"out": str(out), "work": str(folder), **summary})
        return
    typer.echo(summary["answer"])
    typer.echo(f"{out}: open index.html; {folder} speeds up a longer study, and may be removed")


@contextmanager
def _progress(name: str, unit: str, jobs: int, there: int) -> Iterator[Callable[[], None]]:
    """Show a task: on a terminal a bar with rate and time left, otherwise a line at its end."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    if not console.is_interactive:
        yield lambda: None
        kept = f", {there:,} from an earlier run" if there else ""
        print(f"{name}: {jobs:,} {unit}{kept}", file=sys.stderr, flush=True)
        return
    columns = (
        TextColumn(f"{name:>14}"), BarColumn(), MofNCompleteColumn(), TextColumn(unit),
        TextColumn("{task.fields[rate]}"), TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=jobs, completed=there, rate="")

        def advance() -> None:
            bar.advance(task)
            speed = bar.tasks[0].speed
            bar.update(task, rate=f"{speed:,.1f} a second" if speed else "")

        yield advance
