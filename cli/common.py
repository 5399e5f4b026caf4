"""What the commands share: their arguments, their ways to print, and the bar for long work."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from tfra.codegen.core import check_core as check_core

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
def stages() -> Iterator[Callable[[str], None]]:
    """Yield a function that names what is going on; on a terminal a line shows it, with the time since the start."""
    console = Console(stderr=True)
    if not console.is_interactive:
        yield lambda stage: None
        return
    with Progress(SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), console=console) as line:
        task = line.add_task("")
        yield lambda stage: line.update(task, description=stage)
