"""Shared by the commands: arguments, printing, progress of long work."""

import json
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Annotated, Any, Protocol

import typer
from rich.console import Console
from rich.progress import Progress

PATIENCE = 2.0
"""Seconds of work before a progress bar appears."""

INTERVAL = 30.0
"""Seconds between progress lines without a terminal."""

Config = Annotated[Path, typer.Argument(metavar="CONFIG", help="Describes sensor, core and contacts in TOML.")]
Json = Annotated[bool, typer.Option("--json", help="Print only a summary in JSON.")]

WorkFolder = Annotated[
    Path | None,
    typer.Option("--work", metavar="DIR", help="Keeps finished work, so that the command goes on. Default: OUT.work."),
]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="The same seed gives the same random numbers.")]

OutDirectory = Annotated[
    Path,
    typer.Option("--out", metavar="DIR", help="A new or empty directory, or an unchanged one that this command wrote."),
]


def print_json(summary: dict[str, Any]) -> None:
    """Print ``summary`` as indented JSON; raises ``ValueError`` for nan and inf, which JSON lacks."""
    typer.echo(json.dumps(summary, indent=2, allow_nan=False))


@contextmanager
def failures(command: str, *errors: type[Exception], hint: str = "") -> Iterator[None]:
    """When one of ``errors`` is raised in the block, print it with a ``hint`` and end ``command`` with exit code 1."""
    try:
        yield
    except errors as error:
        typer.echo(f"tfra {command}: {error}{hint}", err=True)
        raise typer.Exit(1) from None


def simulation_failures(command: str) -> AbstractContextManager[None]:
    """The same for a simulation that fails."""
    from tfra.sim.run import ProtocolError, SimulationError

    return failures(command, ProtocolError, SimulationError)


PageFile = Annotated[
    Path | None, typer.Option("--page", metavar="FILE.html", help="Also write the report as a page for a browser.")
]


class Advance(Protocol):
    """Counts finished ``pieces``; ``total`` sets their number and ``title`` their name, if they were unknown before."""

    def __call__(self, pieces: int, total: int | None = None, title: str | None = None) -> None: ...


@contextmanager
def progress(title: str, total: int | None = None) -> Iterator[Advance]:
    """Yield a function that counts finished pieces, and show their share and the time left.

    A terminal shows a bar after ``PATIENCE``; otherwise a line is printed every ``INTERVAL``.  Without a total, the
    bar only shows activity, and no lines are printed.
    """
    console = Console(stderr=True)
    if not console.is_interactive:
        yield _Lines(title, total)
        return
    bar = Progress(console=console, transient=True)
    task = bar.add_task(title, total=total)
    timer = threading.Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()

    def advance(pieces: int, total: int | None = None, title: str | None = None) -> None:
        bar.update(task, advance=pieces, total=total, description=title)  # None changes nothing

    try:
        yield advance
    finally:
        timer.cancel()
        timer.join()
        bar.stop()


class _Lines:
    """Progress lines where there is no terminal."""

    def __init__(self, title: str, total: int | None) -> None:
        self._title, self._total, self._done = title, total, 0
        self._begun = self._said = time.monotonic()

    def __call__(self, pieces: int, total: int | None = None, title: str | None = None) -> None:
        self._done, self._total, self._title = self._done + pieces, total or self._total, title or self._title
        now = time.monotonic()
        if not self._total or now - self._said < INTERVAL or self._done == 0:
            return
        self._said = now
        left = (now - self._begun) * (self._total / self._done - 1)
        share = 100 * self._done / self._total
        typer.echo(f"{self._title}: {share:.0f} %, about {spoken(left)} left", err=True)


def spoken(seconds: float) -> str:
    """A time as text, in s, min or h."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    return f"{round(seconds / 60)} min" if seconds < 90 * 60 else f"{seconds / 3600:.1f} h"
