"""What the commands share: their arguments, their ways to print, and the bar for long work."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import typer
from rich.console import Console
from rich.progress import Progress, ProgressColumn, SpinnerColumn, Task, TimeElapsedColumn
from rich.text import Text

from tfra.synth.forecast import spoken

if TYPE_CHECKING:
    from tfra.synth.forecast import Forecast

PATIENCE = 2.0
"""Seconds of work before a progress bar appears."""

INTERVAL = 30.0
"""Seconds between lines about long work where there is no terminal."""


Config = Annotated[Path, typer.Argument(metavar="CONFIG", help="Sensor, core and contacts in TOML.")]
Json = Annotated[bool, typer.Option("--json", help="Print a summary in JSON, and nothing else.")]

OutDirectory = Annotated[
    Path,
    typer.Option(
        "--out", metavar="DIR", help="A new or empty directory, or one that this command wrote and nobody has changed."
    ),
]


def print_json(summary: dict[str, Any]) -> None:
    """Print ``summary`` as indented JSON; raises ``ValueError`` for nan and inf, which JSON lacks."""
    typer.echo(json.dumps(summary, indent=2, allow_nan=False))


@contextmanager
def simulation_failures(command: str) -> Iterator[None]:
    """End ``command`` with exit code 1, after telling why, when a simulation inside the block fails."""
    from tfra.sim.run import ProtocolError, SimulationError

    try:
        yield
    except (ProtocolError, SimulationError) as error:
        typer.echo(f"tfra {command}: {error}", err=True)
        raise typer.Exit(1) from None


PageFile = Annotated[
    Path | None, typer.Option("--page", metavar="FILE.html", help="Write the report as a page for a browser, too.")
]


class Advance(Protocol):
    """Counts finished ``pieces``; ``total`` is how many there are, and ``title`` what they are, if known only now."""

    def __call__(self, pieces: int, total: int | None = None, title: str | None = None) -> None: ...


@contextmanager
def progress(title: str, total: int | None = None) -> Iterator[Advance]:
    """Yield a function that counts finished pieces, and show their share and the time left.

    On a terminal there is a bar after ``PATIENCE``, else a line every ``INTERVAL``.  Without a total there is only a
    bar that shows that work goes on.
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
    """Lines for who has no terminal."""

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


@contextmanager
def forecasts(command: str) -> Iterator[Callable[[Forecast], None]]:
    """Yield a function that shows how far ``command`` is whenever a step begins.

    On a terminal a line goes on showing it; else there is a line for each step from the first that takes long.
    """
    console = Console(stderr=True)
    if not console.is_interactive:
        yield lambda forecast: typer.echo(f"{command}: {forecast}", err=True) if forecast.expected else None
        return
    with Progress(SpinnerColumn(), _ForecastColumn(), TimeElapsedColumn(), console=console, transient=True) as line:
        task = line.add_task("")
        yield lambda forecast: line.update(task, forecast=forecast)


class _ForecastColumn(ProgressColumn):
    """Share and time left, as they are now."""

    def render(self, task: Task) -> Text:
        """The line of a task."""
        return Text(str(task.fields.get("forecast", "")))
