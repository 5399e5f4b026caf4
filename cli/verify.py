"""``tfra verify``: the core against the bit-accurate model, and that against the float reference."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from tfra.cli.common import Config, Json, check_words, print_json, progress, required
from tfra.cli.frames import simulated

if TYPE_CHECKING:
    from tfra.codegen.config import Project
    from tfra.model.sensor import Floats


class Simulator(StrEnum):
    """Who runs the core."""

    ICARUS = "icarus"
    VERILATOR = "verilator"
    AMARANTH = "amaranth"


FramesOption = Annotated[
    Path | None, typer.Option(metavar="FRAMES", help="Stresses in Pa; by default CONFIG's contacts.")
]
SimulatorOption = Annotated[Simulator | None, typer.Option(help="Who runs the core; by default the fastest here.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the random frames and of the stalls.")]
Random = Annotated[int, typer.Option(min=0, help="Random frames to add.")]


def verify(
    config: Config,
    frames: FramesOption = None,
    simulator: SimulatorOption = None,
    seed: Seed = 0,
    random: Random = 0,
    json: Json = False,
) -> None:
    """Run frames through the simulated core and compare every bit; exit 1 when something differs."""
    from tfra.codegen.config import load

    project = load(config)
    check_words(project)
    stresses = _frames(project, frames)
    check = required("tfra.sim.verify", "verify")
    with progress("simulating the core"):
        report = check(project.design, stresses, simulator=simulator and simulator.value, seed=seed, random=random)
    if json:
        print_json(report.as_dict())
    else:
        report.render(Console())
    if not report.passed:
        raise typer.Exit(1)


def _frames(project: Project, path: Path | None) -> Floats:
    """Return the frames to check: those at ``path``, else of CONFIG's contacts, else none."""
    import numpy as np

    from tfra.codegen.framesfile import read_frames

    sensor = project.design.sensor
    if path is not None:
        return read_frames(path, sensor)
    return simulated(project) if project.contacts else np.empty((0, sensor.rows, sensor.columns))
