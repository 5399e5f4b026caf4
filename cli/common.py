"""What the commands share: their arguments, their ways to print, and the bar for long work."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, ProgressColumn, SpinnerColumn, Task, TimeElapsedColumn
from rich.text import Text

from tfra.model.errors import InputError

if TYPE_CHECKING:
    from tfra.codegen.config import Project
    from tfra.synth.forecast import Forecast

PATIENCE = 2.0
"""Seconds of work before a progress bar appears."""


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


def check_core(project: Project) -> None:
    """Prove that no word of the core overflows, and that a core of its kind can hold the design.

    Raises ``InputError`` when the formats are too long or the sensor is too large.
    """
    from tfra.hdl.cores import microarchitecture
    from tfra.model.fixed.advice import advice, fits

    try:
        microarchitecture(project.design).check()
    except ValueError as error:
        nearest = "" if fits(project.design) else advice(project.design)
        raise InputError(project.path, "", f"{error}{nearest and f': {nearest} would do'}") from None


@contextmanager
def simulation_failures(command: str) -> Iterator[None]:
    """End ``command`` with exit code 1, after telling why, when a simulation inside the block fails."""
    from tfra.sim.run import ProtocolError, SimulationError

    try:
        yield
    except (ProtocolError, SimulationError) as error:
        typer.echo(f"tfra {command}: {error}", err=True)
        raise typer.Exit(1) from None


@contextmanager
def progress(title: str, total: int | None = None) -> Iterator[Callable[[int], None]]:
    """Yield a function that counts finished pieces; a bar shows them on a terminal after ``PATIENCE``.

    Without ``total`` the bar only shows that work goes on.
    """
    console = Console(stderr=True)
    if not console.is_interactive:
        yield lambda pieces: None
        return
    bar = Progress(console=console, transient=True)
    task = bar.add_task(title, total=total)
    timer = threading.Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda pieces: bar.advance(task, pieces)
    finally:
        timer.cancel()
        timer.join()
        bar.stop()


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
